"""How long a store of many small artefacts takes: planning, status, start of a run, verification.

    python benchmarks/scale_store.py --designs 20000 --out /tmp/scale

Makes the artefacts of a whole study as small files in the layout of the store (without flushing each to the disk),
then asks what `palpate study status`, the start of `palpate run` and `palpate study store check` ask. The first rows
are a small study that shares the store with all the others, the last ones the study that all of the artefacts belong
to.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from palpate.core import ArtefactStore, check_store, list_store
from palpate.study import Study, find_status, read_study
from palpate.study.plan import plan_study
from palpate.study.schedule import Schedule
from palpate.study.task import Task

CONTENT = b"small artefact"
LAYOUTS = (7, 19, 37, 61, 91, 127, 169, 217)


def grid(designs: int) -> Study:
    """A study of about so many designs: heights of 15 to 20 mm, walls of 1 to 3 mm, eight layouts."""
    side = max(1, round((designs / len(LAYOUTS)) ** 0.5))
    spread = [index / side for index in range(side)]
    heights = [round(15 + 5 * part, 6) for part in spread]
    thicknesses = [round(1 + 2 * part, 6) for part in spread]
    chosen = {"heights": heights, "thicknesses": thicknesses, "markers": list(LAYOUTS)}
    return Study.model_validate({"name": "scale", "designs": chosen})


def fill(store: ArtefactStore, tasks: tuple[Task, ...]) -> None:
    """Put a small file under the key of every task."""
    checksum = hashlib.sha256(CONTENT).hexdigest()
    for task in tasks:
        recipe, path = task.recipe, store.path(task.recipe, task.suffix)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(CONTENT)
        manifest = {"kind": recipe.kind, "key": recipe.key, "sha256": checksum, "bytes": len(CONTENT)}
        path.with_suffix(".manifest.json").write_text(json.dumps(manifest, indent=2) + "\n")


@contextmanager
def timed(what: str) -> Iterator[None]:
    started = time.perf_counter()
    yield
    print(f"| {what} | {time.perf_counter() - started:.2f} |", flush=True)


def start(tasks: Callable[[], tuple[Task, ...]], store: ArtefactStore) -> None:
    """What a run does before the first task is given to a worker."""
    planned = tasks()
    made = {task.recipe.key for task in planned if store.has(task.recipe, task.suffix)}
    todo = [task for task in planned if task.recipe.key not in made]
    Schedule(todo, made).next_task()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--designs", type=int, default=20_000)
    parser.add_argument("--out", type=Path, required=True, help="new folder; removed at the end")
    chosen = parser.parse_args()
    study, small = grid(chosen.designs), read_study("paper")
    store = ArtefactStore(chosen.out / "store")
    chosen.out.mkdir(parents=True)
    try:
        print("| what | s |\n|---|---|")
        with timed(f"plan of {len(study.designs.skins()) * len(LAYOUTS)} designs"):
            plan = plan_study(study)
            tasks = plan.tasks()
        with timed(f"writing {len(tasks)} artefacts"):
            fill(store, tasks)
        with timed("listing the store"):
            count = len(list_store(store.root).artefacts)
        assert count == len(tasks)
        with timed("status of the paper's 48 designs in this store"):
            find_status(small, chosen.out)
        with timed("start of a run of the paper's 48 designs in this store"):
            start(lambda: plan_study(small).tasks(), store)
        with timed("looking at every artefact, as at the start of a run"):
            start(lambda: tasks, store)
        with timed("order of as many tasks in an empty store"):
            Schedule(tasks, []).next_task()
        with timed("start of a run of the whole study, planning included"):
            start(lambda: plan_study(study).tasks(), store)
        with timed("status of the whole study, planning included"):
            find_status(study, chosen.out)
        with timed("verifying every checksum"):
            read, broken = check_store(store.root)
        assert (read, broken) == (len(tasks), ())
    finally:
        shutil.rmtree(chosen.out)


if __name__ == "__main__":
    main()
