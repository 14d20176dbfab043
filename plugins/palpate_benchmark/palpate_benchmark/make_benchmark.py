"""Generation of the data set: simulate every unit, number the images, and write all files.

The same spec gives the same bytes. Each unit belongs to one split: train, calibrate or test. Images are numbered in a
random order over the whole set and sorted by number in every file, so that neither number nor position reveals press
or depth. The labels of the test are in separate files.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from palpate.core import ArtefactStore, IntArray, PalpateError, atomic_folder, child_seed, generator
from palpate.core.run import Progress
from palpate.study import find_artefact, run_tasks, write_json
from palpate.surrogate import read_twin
from palpate_benchmark.set_files import CHECKSUMS, SET, SplitPart, list_files, write_designs, write_split, write_units
from palpate_benchmark.simulate_unit import deviation_of
from palpate_benchmark.spec import SPLITS, BenchmarkSpec
from palpate_benchmark.unit_images import UnitImages, read_unit_images
from palpate_benchmark.unit_task import BenchmarkUnitTask, plan_units
from palpate_benchmark.write_card import SetCounts, write_card
from palpate_benchmark.write_croissant import write_croissant


@dataclass(frozen=True)
class BenchmarkFiles:
    """Files of a data set.

    Attributes
    ----------
    folder
        Folder of the data set.
    counts
        Numbers of images and presses.
    bytes
        Size of all files.
    sha256
        Checksum of the list of all files' checksums.
    """

    folder: Path
    counts: SetCounts
    bytes: int
    sha256: str


def make_benchmark(
    spec: BenchmarkSpec, out: Path, workers: int | None = None, progress: Progress | None = None
) -> BenchmarkFiles:
    """Make the data set in ``out/set``; results of an earlier run in ``out/store`` are reused.

    Parameters
    ----------
    spec
        Contents of the data set.
    out
        Result folder.
    workers
        Worker processes; `None`: one per core.
    progress
        Receives each task.

    Raises
    ------
    PalpateError
        If a press cannot be solved, or the folder cannot be written.
    """
    tasks = plan_units(spec)
    failed = run_tasks(out, tasks, workers, progress)
    if failed:
        first = next(task for task in tasks if task.recipe.key in failed)
        raise PalpateError(
            f"{len(failed)} of {len(tasks)} units could not be simulated; {first.name}: {failed[first.recipe.key]}",
            "Change the designs or the twin's presses, and run the same command again.",
            code="units-not-drawn",
        )
    store, folder = ArtefactStore(out / "store"), out / SET
    if (folder / CHECKSUMS).is_file():
        shutil.rmtree(folder)
    off = {
        task.design.name: float(read_twin(find_artefact(store, task.twin)).interpolation_error_mm) for task in tasks
    }
    numbers = _number(spec)
    images: dict[str, int] = {}
    pictures: dict[str, int] = {}
    with atomic_folder(folder) as draft:
        write_json(draft / "spec.json", spec.model_dump(mode="json", exclude={"hidden_seed"}))
        write_designs(draft, spec)
        for split in SPLITS:
            parts = [
                SplitPart(task.design, task.unit, number, _press_number(spec, place), found)
                for place, (task, number) in enumerate(zip(tasks, numbers, strict=True))
                if spec.split_of(task.unit) == split
                for found in [_read(store, task)]
            ]
            images[split], pictures[split] = write_split(draft, split, parts)
            built = [(part.design.name, deviation_of(spec, part.design, part.unit)) for part in parts]
            write_units(draft, split, built)
        presses: dict[str, int] = {
            split: sum(spec.split_of(task.unit) == split for task in tasks) * spec.presses for split in SPLITS
        }
        counts = SetCounts(images, pictures, presses, off)
        write_card(draft, spec, counts)
        write_croissant(draft, spec)
        size, sha256 = list_files(draft)
    return BenchmarkFiles(folder, counts, size, sha256)


def _read(store: ArtefactStore, task: BenchmarkUnitTask) -> UnitImages:
    return read_unit_images(find_artefact(store, task))


def _number(spec: BenchmarkSpec) -> Sequence[IntArray]:
    """Draw the image numbers of every unit, in a random order over all units."""
    each, count = spec.presses * spec.images, spec.units * len(spec.designs)
    seed = spec.seed if spec.hidden_seed is None else child_seed(spec.hidden_seed, "numbers")
    order = generator(seed, "numbers").permutation(each * count)
    return np.split(order, count)


def _press_number(spec: BenchmarkSpec, place: int) -> int:
    """Return the number of the first press of the unit at this position."""
    return place * spec.presses
