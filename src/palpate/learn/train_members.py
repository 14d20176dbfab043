"""The parts of a model: those that the store holds, and those to be trained, networks beside each other.

Several networks get a process each: two threads of one network wait for each other, on a busy machine for most of the
time.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from palpate.core import ArtefactStore, PalpateError, Recipe, stage_version
from palpate.core.named_arrays import read_arrays, write_arrays
from palpate.core.run import Call, LocalWorkers, Outcome, Progress, Status
from palpate.learn.member import PARTS, EnsembleMember
from palpate.learn.train_member import train_image_network, train_marker_network, train_rotated_network
from palpate.learn.trainer import IMAGE_S, TrainerSpec, load_torch
from palpate.learn.training_set import TrainingSet, fit_ridge_part

ROTATED = "-turned"
"""End of the names of networks that are taught by turned presses as well."""
_LONGER = 8 / 3
"""Passes of the network on turned pictures over those of the other: what comes in six ways bears longer training."""
_MOST_SHOWN = 250_000
"""Pictures that these passes show at most, unless the other's show more: 35 to 50 minutes of a core."""
_MARKERS_S = 60.0
"""Time of one core to train a network on markers, s; it decides only the remaining time."""
_WAIT_S = 0.5
"""Time for which the pool is waited for, s."""


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

    @property
    def cost(self) -> float:
        """Expected time of one core, s."""
        if self.sees_pictures:
            return IMAGE_S * self.passes * int(self.training_set.train.sum())
        return _MARKERS_S if self.is_network else 0.0

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

    def train(self, threads: int, checkpoint: Path, progress: Progress) -> Mapping[str, NDArray[Any]]:
        """Arrays of the part; what is known meanwhile lies in the file `checkpoint`."""
        if self.sees_pictures:
            course = TrainerSpec(self.passes, threads=threads)
            return train_image_network(
                self.name, self.training_set, self.n_outputs, course, checkpoint, progress
            ).arrays
        if not self.is_network:
            return fit_ridge_part(self.name, self.training_set, self.name.startswith("picture")).arrays
        train = train_rotated_network if self.name.endswith(ROTATED) else train_marker_network
        progress.begin(self.name, self.cost)
        arrays = train(self.name, self.training_set, checkpoint=checkpoint).arrays
        progress.finish(self.name)
        return arrays


class TrainedMember(NamedTuple):
    """A part, and the time in s that it took now."""

    part: EnsembleMember
    seconds: float


def train_members(
    jobs: Sequence[TrainingJob], threads: int, store: ArtefactStore, progress: Progress
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
    progress
        Receives each epoch, and the end of each network.

    Raises
    ------
    PalpateError
        If a training process dies, or finds what the user can mend.
    """
    missing = [job for job in jobs if job.is_network and store.find(job.recipe) is None]
    workers = min(threads, len(missing))
    progress.plan(sum(job.cost for job in missing))
    for job in jobs:
        if workers > 1 and job in missing:
            continue
        begin = time.monotonic()
        path = store.find(job.recipe)
        if path is None:
            path = _keep(store, job, job.train(threads, _draft(store, job), progress))
        yield TrainedMember(_read(job, path), time.monotonic() - begin)
    if workers > 1:
        for job, arrays, seconds in _train_in_processes(missing, workers, threads // workers, store, progress):
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
    jobs: Sequence[TrainingJob], workers: int, threads: int, store: ArtefactStore, progress: Progress
) -> Iterator[tuple[TrainingJob, Mapping[str, NDArray[Any]], float]]:
    """Train networks in processes: those on dots first, which take minutes, then the longest."""
    load_torch()  # a missing library is reported here
    queue = sorted(jobs, key=lambda job: (job.sees_pictures, -job.passes))
    running: dict[Call, TrainingJob] = {}
    with LocalWorkers(workers) as pool:
        while queue or running:
            while queue and len(running) < workers:
                job = queue.pop(0)
                running[pool.submit(job.train, threads, _draft(store, job), progress=progress)] = job
            for call, outcome in pool.wait(_WAIT_S):
                job = running.pop(call)
                yield job, _arrays(job, outcome), outcome.seconds


def _arrays(job: TrainingJob, outcome: Outcome) -> Mapping[str, NDArray[Any]]:
    """Arrays of a part that was trained in a process."""
    if outcome.status is Status.DONE:
        arrays: Mapping[str, NDArray[Any]] = outcome.value
        return arrays
    if outcome.error is not None:
        raise outcome.error
    if outcome.status is Status.DIED:
        raise PalpateError(
            f"The training of {job.name} ended: {outcome.reason}.",
            "Start again, it goes on where it was; with --threads 1 one network is trained at a time. In a script of "
            'your own, call it under `if __name__ == "__main__":`.',
            code="training-process-died",
        )
    raise RuntimeError(f"The training of {job.name} failed: {outcome.trace or outcome.reason}")
