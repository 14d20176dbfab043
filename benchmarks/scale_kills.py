"""Kill a study at random instants and go on each time: nothing finished may be lost, half-written or made twice.

    python benchmarks/scale_kills.py studies/first.yaml --kills 100 --out /tmp/kills

One undisturbed run gives the grid. Then the study is started, ended by SIGKILL with all of its workers, and started
again until it ends; a new folder is begun until there were enough kills, and the last one may end in peace. After
each kill every artefact is verified. The instants are even in the logarithm of time, so that many hit the start and
some leave time for a training of half a minute, which a kill sends back to its beginning. The same command goes on
where it was ended.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

from palpate.core import check_store, clean_store

ENTRY = "from palpate.cli import main; main()"


def start(study: Path, out: Path, workers: int) -> subprocess.Popen[bytes]:
    """Start a run in a process group of its own."""
    words = [sys.executable, "-c", ENTRY, "run", str(study), "--out", str(out), "--workers", str(workers)]
    return subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, start_new_session=True)


def written(out: Path) -> dict[str, int]:
    """When each artefact was written, ns."""
    manifests = (out / "store").rglob("*.manifest.json")
    return {path.name: path.stat().st_mtime_ns for path in manifests if _has_artefact(path)}


def _has_artefact(manifest: Path) -> bool:
    key = manifest.name.removesuffix(".manifest.json")
    return any((manifest.parent / f"{key}{suffix}").exists() for suffix in (".h5", ".json", ".onnx"))


def kill_until_done(study: Path, out: Path, chosen: argparse.Namespace, draw: random.Random, most: int) -> int:
    """Run one folder to its end over so many kills at most; the number of kills."""
    kills, before = 0, dict[str, int]()
    while True:
        process = start(study, out, chosen.workers)
        try:
            process.wait(timeout=chosen.longest ** draw.random() - 1.0 if kills < most else None)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
            kills += 1
        time.sleep(1.5)  # workers without their parent look for it each second
        after = written(out)
        read, broken = check_store(out / "store")
        print(f"kill {kills}: {read} whole, {len(broken)} broken", flush=True)
        assert not broken, broken
        assert before.items() <= after.items(), "an artefact was lost or made twice"
        before = after
        if process.returncode == 0:
            return kills


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", type=Path)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--longest", type=float, default=90.0, help="longest time before a kill, s")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, required=True, help="folder of the runs")
    chosen = parser.parse_args()
    draw = random.Random(chosen.seed)
    study = chosen.study.resolve()
    if start(study, chosen.out / "undisturbed", chosen.workers).wait() != 0:
        raise SystemExit("the undisturbed run failed")
    grid = (chosen.out / "undisturbed" / "grid.csv").read_bytes()
    kills = folders = 0
    while kills < chosen.kills:
        out = chosen.out / f"killed-{folders}"
        kills += kill_until_done(study, out, chosen, draw, chosen.kills - kills)
        folders += 1
        assert (out / "grid.csv").read_bytes() == grid, "the grid differs from the undisturbed one"
        left = clean_store(out / "store", [path.name[:32] for path in (out / "store").rglob("*.manifest.json")])
        print(f"{folders} studies ended, {kills} kills, the same grid; {len(left)} leftovers removed", flush=True)


if __name__ == "__main__":
    main()
