"""The parts of a model: those that the store holds, and those to be trained, networks beside each other.

Several networks get a process each: two threads of one network wait for each other, on a busy machine for most of the
time.
"""

from __future__ import annotations

import hashlib
import multiprocessing
import os
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from multiprocessing.connection import wait
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from palpate.core import ArtefactStore, PalpateError, Recipe, stage_version, worker_process
from palpate.recording.arrays import read_arrays, write_arrays
from palpate.recording.course import TrainerSpec, load_torch
from palpate.recording.lesson import TrainingSet, fit_ridge_part
from palpate.recording.part import PARTS, EnsembleMember
from palpate.recording.see_recording import Report
from palpate.recording.train_part import train_image_network, train_marker_network, train_rotated_network

ROTATED = "-turned"
"""End of the names of networks that are taught by turned presses as well."""
_LONGER = 8 / 3
"""Passes of the network on turned pictures over those of the other: what comes in six ways bears longer training."""
_MOST_SHOWN = 250_000
"""Pictures that these passes show at most, unless the other's show more: 35 to 50 minutes of a core."""


@dataclass(frozen=True, eq=False)
class TrainingJob:
    """One part to be made.

    Attributes
    ----------
    name, training_set
        Of the part, and what it learns from.
    n_outputs
        Number of targets that it hands on, the first of the lesson's.
    epochs
        Passes over pictures as they are.
    seed
        Seed of weights and batches.
    """

    name: str
    training_set: TrainingSet
    n_outputs: int
    epochs: int
    seed: int

    @property
    def is_network(self) -> bool:
        """Whether it is worth a process."""
        return "network" in self.name

    @property
    def sees_pictures(self) -> bool:
        """Whether it is a network on pictures, whose passes are chosen."""
        return "picture-network" in self.name

    @property
    def passes(self) -> int:
        """Passes over what teaches, of a network on pictures."""
        taught = max(int(self.training_set.train.sum()), 1)
        if not self.name.endswith(ROTATED):
            return self.epochs
        return max(self.epochs, min(round(_LONGER * self.epochs), _MOST_SHOWN // taught))

    @cached_property
    def recipe(self) -> Recipe:
        """What it is made from."""
        digest = hashlib.sha256()
        for array in (
            self.training_set.inputs,
            self.training_set.targets,
            self.training_set.train,
            self.training_set.validation,
        ):
            digest.update(np.ascontiguousarray(array).tobytes())
        turning = self.training_set.rotation
        if turning is not None:
            for array in (turning.places_px, turning.base_px):
                digest.update(np.ascontiguousarray(array).tobytes())
        sense = 0 if turning is None else turning.sense
        own = [
            self.name,
            digest.hexdigest(),
            self.n_outputs,
            sense,
            self.seed,
            self.passes if self.sees_pictures else 0,
        ]
        return Recipe("part", own, version=stage_version("recorded_estimator"))

    def train(self, threads: int, checkpoint: Path, report: Report) -> Mapping[str, NDArray[Any]]:
        """Arrays of the part; what is known meanwhile lies in the file `checkpoint`."""
        if not self.is_network:
            return fit_ridge_part(self.name, self.training_set, self.name.startswith("picture")).arrays
        if self.sees_pictures:
            course = TrainerSpec(self.passes, threads=threads)
            return train_image_network(
                self.name, self.training_set, self.n_outputs, course, checkpoint, report
            ).arrays
        train = train_rotated_network if self.name.endswith(ROTATED) else train_marker_network
        return train(self.name, self.training_set, checkpoint=checkpoint).arrays


class TrainedMember(NamedTuple):
    """A part, and the time in s that it took now."""

    part: EnsembleMember
    seconds: float


def train_members(
    jobs: Sequence[TrainingJob], threads: int, store: ArtefactStore, report: Report
) -> Iterator[TrainedMember]:
    """Make parts, and give each as soon as it is there.

    Parameters
    ----------
    jobs
        What is to be made.
    threads
        Cores that networks may use: of several, each that is missing is trained in a process of its own.
    store
        Where parts are kept, and what an interrupted training needs to go on.
    report
        Told how far it is.

    Raises
    ------
    PalpateError
        If a training process dies, or finds what the user can mend.
    """
    missing = [job for job in jobs if job.is_network and store.find(job.recipe) is None]
    workers = min(threads, len(missing))
    for job in jobs:
        if workers > 1 and job in missing:
            continue
        begin = time.monotonic()
        path = store.find(job.recipe)
        if path is None:
            path = _keep(store, job, job.train(threads, _draft(store, job), report))
        yield TrainedMember(_read(job, path), time.monotonic() - begin)
    if workers > 1:
        for job, arrays, seconds in _train_in_processes(missing, workers, threads // workers, store, report):
            yield TrainedMember(_read(job, _keep(store, job, arrays)), seconds)


def _draft(store: ArtefactStore, job: TrainingJob) -> Path:
    """File of what is known before a training's end; members of a network add to its name."""
    kept = store.path(job.recipe, ".epochs")
    kept.parent.mkdir(parents=True, exist_ok=True)
    return kept


def _keep(store: ArtefactStore, job: TrainingJob, arrays: Mapping[str, NDArray[Any]]) -> Path:
    path = store.write(job.recipe, lambda file: write_arrays(file, arrays))
    kept = _draft(store, job)
    for left in kept.parent.glob(f"{kept.stem}.*"):
        if left.suffix not in (".h5", ".json"):
            left.unlink(missing_ok=True)
    return path


def _read(job: TrainingJob, path: Path) -> EnsembleMember:
    kind = "linear" if not job.is_network else "picture-network" if job.sees_pictures else "dots-network"
    return PARTS[kind](job.name, read_arrays(path))


def _train_in_processes(
    jobs: Sequence[TrainingJob], workers: int, threads: int, store: ArtefactStore, report: Report
) -> Iterator[tuple[TrainingJob, Mapping[str, NDArray[Any]], float]]:
    """Train networks in processes: those on dots first, which take minutes, then the longest."""
    load_torch()  # what is missing is told here
    context = multiprocessing.get_context("spawn")
    queue = sorted(jobs, key=lambda job: (job.sees_pictures, -job.passes))
    busy: dict[Any, tuple[TrainingJob, Any, float]] = {}
    try:
        while queue or busy:
            while queue and len(busy) < workers:
                job, (here, there) = queue.pop(0), context.Pipe(duplex=False)
                arguments = (job, threads, _draft(store, job), there, os.getpid())
                process = context.Process(target=_work, args=arguments, daemon=True)
                with worker_process.single_threaded():
                    process.start()
                there.close()
                busy[here] = job, process, time.monotonic()
            for pipe in wait(list(busy)):
                job, process, begin = busy[pipe]
                told = _hear(pipe, job, process)
                if isinstance(told, str):
                    report(told)
                    continue
                del busy[pipe]
                process.join()
                yield job, told, time.monotonic() - begin
    finally:
        for _, process, _ in busy.values():
            process.kill()


def _hear(pipe: Any, job: TrainingJob, process: Any) -> str | Mapping[str, NDArray[Any]]:
    """How far a process is, or at its end the arrays of its part."""
    try:
        told: str | PalpateError | Mapping[str, NDArray[Any]] = pipe.recv()
    except (EOFError, OSError) as error:
        process.join()
        raise PalpateError(
            f"The process that trained {job.name} ended with code {process.exitcode}, perhaps for want of memory.",
            "Start again, it goes on where it was; with --threads 1 one network is trained at a time. In a script of "
            'your own, call it under `if __name__ == "__main__":`.',
            code="training-process-died",
        ) from error
    if isinstance(told, PalpateError):
        raise told
    return told


def _work(job: TrainingJob, threads: int, checkpoint: Path, pipe: Any, parent: int) -> None:
    """What a process does; what the user can mend is handed on."""
    worker_process.attach_to_parent(parent)
    try:
        pipe.send(dict(job.train(threads, checkpoint, pipe.send)))
    except PalpateError as error:
        pipe.send(PalpateError(error.problem, error.remedy, code=error.code))
