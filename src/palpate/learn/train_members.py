"""Training of the estimators of a model that the store lacks, networks in parallel processes.

Several networks get a process each: two threads of one network wait for each other, on a busy machine for most of the
time.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from palpate.core import ArtefactStore, PalpateError, Recipe, load_extra, stage_version
from palpate.core.named_arrays import read_arrays, write_arrays
from palpate.core.run import Call, LocalWorkers, Outcome, Progress, Status
from palpate.learn.member import EnsembleMember, TrainingRun
from palpate.learn.training_set import TrainingSet


@dataclass(frozen=True, eq=False)
class TrainingJob:
    """One estimator to be trained.

    Attributes
    ----------
    kind, name
        Its class, and its name in the model.
    samples
        Samples that it is trained on.
    epochs
        Passes over images as they are.
    """

    kind: type[EnsembleMember]
    name: str
    samples: TrainingSet
    epochs: int

    @property
    def cost(self) -> float:
        """Expected time of one core, s; 0 for a closed form, which is not worth a process."""
        return self.kind.cost(self.samples, self.epochs)

    @cached_property
    def recipe(self) -> Recipe:
        """Recipe of the estimator."""
        digest, samples, rotation = hashlib.sha256(), self.samples, self.samples.rotation
        arrays = [samples.inputs, samples.targets, samples.train, samples.validation, samples.press_numbers]
        for array in arrays + ([] if rotation is None else [rotation.places_px, rotation.base_px]):
            digest.update(np.ascontiguousarray(array).tobytes())
        symmetry = None if rotation is None else rotation[2:]
        passes = self.kind.passes(samples, self.epochs)
        own = [self.name, digest.hexdigest(), samples.n_outputs, symmetry, samples.seed, passes]
        return Recipe("part", own, version=stage_version("recorded_estimator", self.kind))

    def train(self, threads: int, checkpoint: Path, progress: Progress) -> EnsembleMember:
        """Train it; the state of an interrupted training is in the file `checkpoint`."""
        return self.kind.train(self.name, self.samples, TrainingRun(self.epochs, threads, checkpoint, progress))


def train_members(
    jobs: Sequence[TrainingJob], threads: int, store: ArtefactStore, progress: Progress
) -> Iterator[tuple[EnsembleMember, float]]:
    """Train estimators; yield each with its training time in s, as soon as it is trained.

    Parameters
    ----------
    jobs
        Estimators to train.
    threads
        Cores for networks: with several, each missing network is trained in its own process.
    store
        Store of estimators, and of checkpoints of interrupted trainings.
    progress
        Receives each epoch, and the end of each network.

    Raises
    ------
    PalpateError
        If a training process dies, or raises a `PalpateError`.
    """
    missing = [job for job in jobs if job.cost and store.find(job.recipe) is None]
    workers = min(threads, len(missing))
    progress.plan(sum(job.cost for job in missing))
    for job in jobs:
        if workers > 1 and job in missing:
            continue
        begin = time.monotonic()
        path = store.find(job.recipe)
        if path is None:
            path = _keep(store, job, job.train(threads, _draft(store, job), progress))
        yield job.kind(job.name, read_arrays(path)), time.monotonic() - begin
    if workers > 1:
        for job, member, seconds in _train_in_processes(missing, workers, threads // workers, store, progress):
            yield job.kind(job.name, read_arrays(_keep(store, job, member))), seconds


def _draft(store: ArtefactStore, job: TrainingJob) -> Path:
    """File of the checkpoint of a training; members of a network add to its name."""
    kept = store.path(job.recipe, ".epochs")
    kept.parent.mkdir(parents=True, exist_ok=True)
    return kept


def _keep(store: ArtefactStore, job: TrainingJob, member: EnsembleMember) -> Path:
    path = store.write(job.recipe, lambda file: write_arrays(file, member.arrays))
    kept = _draft(store, job)
    for left in kept.parent.glob(f"{kept.stem}.*"):
        if left.suffix not in (".h5", ".json"):
            left.unlink(missing_ok=True)
    return path


def _train_in_processes(
    jobs: Sequence[TrainingJob], workers: int, threads: int, store: ArtefactStore, progress: Progress
) -> Iterator[tuple[TrainingJob, EnsembleMember, float]]:
    """Train networks in processes: those on markers first, which take minutes, then the longest."""
    load_extra("torch", "learn")  # a missing library is reported here
    queue = sorted(jobs, key=lambda job: (not job.kind.reads_markers, -job.cost))
    running: dict[Call, TrainingJob] = {}
    with LocalWorkers(workers) as pool:
        while queue or running:
            while queue and len(running) < workers:
                job = queue.pop(0)
                running[pool.submit(job.train, threads, _draft(store, job), progress=progress)] = job
            for call, outcome in pool.wait():
                job = running.pop(call)
                yield job, _trained(job, outcome), outcome.seconds


def _trained(job: TrainingJob, outcome: Outcome) -> EnsembleMember:
    """The estimator that was trained in a process."""
    if outcome.status is Status.DONE:
        member: EnsembleMember = outcome.value
        return member
    if outcome.error is not None:
        raise outcome.error
    if outcome.status is Status.DIED:
        raise PalpateError(
            f"The training of {job.name} ended: {outcome.reason}.",
            "Start again to resume it; with --threads 1 one network is trained at a time. In a script of "
            'your own, call it under `if __name__ == "__main__":`.',
            code="training-process-died",
        )
    raise RuntimeError(f"The training of {job.name} failed: {outcome.trace or outcome.reason}")
