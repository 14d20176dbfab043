"""The training loop: networks as slices of the same tensors, each with its own random stream.

A parameter has the shape (r, …) for r members, so that one product serves all. Each member has its own order of
samples, augmentation and learning rate, and stops by itself; its numbers do not depend on the remaining members.
Other kinds of networks are trained with r = 1.
"""

from __future__ import annotations

import math
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import torch

from palpate.core import PalpateError, atomic_write
from palpate.core.run import Progress

if TYPE_CHECKING:
    from torch import Generator, Tensor

BETA_1, BETA_2, EPSILON = 0.9, 0.999, 1e-8
"""Constants of AdamW (Kingma & Ba 2015; Loshchilov & Hutter 2019)."""
MATRIX_BETA, POLYNOMIAL, POLYNOMIAL_STEPS = 0.95, (3.4445, -4.7750, 2.0315), 3
"""Constants of Muon (Jordan et al. 2024); three steps train as well as their five."""
WARM_UP = 200
"""Steps over which the learning rate of the cosine schedule rises, at most a fifth of all. By hand."""
_BETWEEN_S = 5.0
"""Time between two checkpoints, s."""


def fall(done: float) -> float:
    """Cosine from 1 to 0, for the share of the training that is done."""
    return 0.5 * (1.0 + math.cos(math.pi * done))


def fall_from_warm_up(step: int, steps: int) -> float:
    """Share of the learning rate in a step from 1: a short rise, then a cosine."""
    return fall(step / steps) * min(1.0, step / min(WARM_UP, 0.2 * steps + 1))


@dataclass(frozen=True)
class TrainerSpec:
    """Settings of the training of networks.

    Attributes
    ----------
    epochs, batch, learning_rate, weight_decay
        Passes over the samples at most, samples of a batch, learning rate at the start, weight decay of AdamW.
    matrix_rate
        Learning rate of Muon for hidden weights at the start; 0: AdamW for all weights.
    schedule
        Learning rate over that at the start, by step from 1 and number of steps; the default rises in at most a fifth
        of the training.
    keep_best
        Whether the weights of the epoch of minimum validation error are kept, or those of the last epoch.
    stopping_patience, plateau_patience, plateau_factor
        Epochs without progress before a member stops, and before its rate falls by the factor.
    anchor_weight
        Pull of the weights towards their start.
    threads
        Cores that it may use.
    """

    epochs: int
    batch: int = 32
    learning_rate: float = 2e-3
    matrix_rate: float = 0.0
    weight_decay: float = 2e-2
    schedule: Callable[[int, int], float] = fall_from_warm_up
    keep_best: bool = True
    stopping_patience: float = math.inf
    plateau_patience: float = math.inf
    plateau_factor: float = 1.0
    anchor_weight: float = 0.0
    threads: int = 1


class TrainingTask(ABC):
    """Networks and their samples.

    Attributes
    ----------
    parameters
        Tensors (r, …) that are trained.
    buffers
        Other tensors of the state of the network, such as running means.
    rows
        (n,) numbers of the training samples.
    matrices
        Numbers of the parameters that are weights (r, in, out) of hidden layers.
    """

    parameters: list[Tensor]
    matrices: Sequence[int] = ()
    buffers: Sequence[Tensor] = ()
    rows: Tensor

    @abstractmethod
    def draw(self, rows: Tensor, done: float, random: Sequence[Generator]) -> tuple[Tensor, Tensor]:
        """Inputs (r, b, …) and targets (r, b, k) of a batch (r, b), augmented; `done` is the share trained."""

    @abstractmethod
    def forward(self, parameters: list[Tensor], inputs: Tensor, random: Sequence[Generator] | None) -> Tensor:
        """Outputs (r, b, k) of inputs (r, b, …); without random streams for evaluation."""

    @abstractmethod
    def validation(self) -> Iterable[tuple[Tensor, Tensor]]:
        """Batches of validation samples: inputs (1, b, …) and targets (b, k)."""


@dataclass(eq=False)
class TrainedState:
    """One member in training.

    Attributes
    ----------
    random, rate
        Random stream, and factor of the learning rate.
    best, best_epoch, waited
        Minimum validation error, the epoch of `state` from 0, epochs since then.
    state
        Parameters and buffers that are kept, without the dimension of the members.
    errors
        Validation error after each epoch (root mean square of standardised targets).
    """

    random: Generator
    rate: float = 1.0
    best: float = math.inf
    best_epoch: int = -1
    waited: int = 0
    state: list[Tensor] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)


class Trainer:
    """The loop over epochs; `active` are the members that still train, by the rows of the tensors."""

    def __init__(self, task: TrainingTask, spec: TrainerSpec, random: Sequence[Generator]) -> None:
        self.task, self.spec, self.epoch = task, spec, 0
        self.members = [TrainedState(stream) for stream in random]
        self.active = list(self.members)
        self.parameters = task.parameters
        self.start = [value.detach().clone() for value in task.parameters] if spec.anchor_weight else []
        self.moments = [(torch.zeros_like(one), torch.zeros_like(one)) for one in task.parameters]

    def run(
        self,
        checkpoint: Path | None = None,
        progress: Progress | None = None,
        name: str = "network",
        cost: float = 1.0,
    ) -> list[TrainedState]:
        """Train every member until it stops or the epochs are spent.

        Parameters
        ----------
        checkpoint
            File of the state every few seconds, from which an interrupted training resumes; `None` for no file.
        progress, name, cost
            Receives each epoch of the network of this name and cost.

        Raises
        ------
        PalpateError
            If an error is not a number.
        """
        threads, saved, progress = torch.get_num_threads(), time.monotonic(), progress or Progress()
        torch.set_num_threads(self.spec.threads)
        try:
            if checkpoint is not None and checkpoint.is_file():
                self._resume(checkpoint)
            progress.begin(name, cost, cost * self.epoch / self.spec.epochs)
            while self.active and self.epoch < self.spec.epochs:
                self._train()
                error = self._validate()
                self.epoch += 1
                if checkpoint is not None and time.monotonic() - saved > _BETWEEN_S:
                    self._save(checkpoint)
                    saved = time.monotonic()
                text = f"epoch {self.epoch} of {self.spec.epochs}, validation error {error:.4f} of the deviation"
                progress.advance(name, cost * self.epoch / self.spec.epochs, text)
            progress.finish(name)
        finally:
            torch.set_num_threads(threads)
        for row, member in enumerate(self.active):
            if not (self.spec.keep_best and member.state):
                member.state, member.best_epoch = self._copy(row), len(member.errors) - 1
        return self.members

    def _copy(self, row: int) -> list[Tensor]:
        return [one[row].detach().clone() for one in self.parameters] + [one.clone() for one in self.task.buffers]

    def _train(self) -> None:
        task, random = self.task, [member.random for member in self.active]
        drawn = [torch.randperm(len(task.rows), generator=one, device=task.rows.device) for one in random]
        order = task.rows[torch.stack(drawn)]
        batches = [
            rows for rows in torch.split(order, self.spec.batch, dim=1) if rows.shape[1] > 1 or len(task.rows) == 1
        ]
        steps = self.spec.epochs * len(batches)
        for number, rows in enumerate(batches):
            step = self.epoch * len(batches) + number + 1
            inputs, targets = task.draw(rows, step / steps, random)
            outputs = task.forward(self.parameters, inputs, random)
            # the sum over members keeps the gradient of each its own
            loss = ((outputs - targets) ** 2).mean(dim=(1, 2)).sum()
            for now, start in zip(self.parameters, self.start, strict=False):
                loss = loss + self.spec.anchor_weight * ((now - start) ** 2).sum()
            self._step(torch.autograd.grad(loss, self.parameters), step, steps)

    @torch.no_grad()
    def _step(self, gradients: Sequence[Tensor], step: int, steps: int) -> None:
        """One step of AdamW, or of Muon for hidden weights, with a learning rate for each member."""
        factor = self.spec.learning_rate * self.spec.schedule(step, steps)
        rates = torch.tensor([factor * member.rate for member in self.active], device=self.parameters[0].device)
        corrected = rates / (1.0 - BETA_1**step)
        for number, (parameter, gradient) in enumerate(zip(self.parameters, gradients, strict=True)):
            mean, square = self.moments[number]
            shape = (-1, *(1,) * (parameter.dim() - 1))
            if self.spec.matrix_rate and number in self.task.matrices:
                mean.lerp_(gradient, 1.0 - MATRIX_BETA)
                scale = self.spec.matrix_rate / self.spec.learning_rate
                scale *= math.sqrt(max(1.0, parameter.shape[2] / parameter.shape[1]))
                parameter.sub_(scale * rates.view(shape) * orthogonalise(gradient.lerp(mean, MATRIX_BETA)))
                continue
            mean.lerp_(gradient, 1.0 - BETA_1)
            square.mul_(BETA_2).addcmul_(gradient, gradient, value=1.0 - BETA_2)
            size = (square / (1.0 - BETA_2**step)).sqrt_().add_(EPSILON)
            if self.spec.weight_decay:
                parameter.mul_(1.0 - rates.view(shape) * self.spec.weight_decay)
            parameter.sub_(corrected.view(shape) * mean / size)

    @torch.no_grad()
    def _validate(self) -> float:
        """Measure validation errors, end members without progress, and return the mean error."""
        count, squares = len(self.active), []
        for inputs, targets in self.task.validation():
            outputs = self.task.forward(self.parameters, inputs.expand(count, *inputs.shape[1:]), None)
            squares.append(((outputs - targets) ** 2).mean(dim=2))
        errors = torch.cat(squares, dim=1).mean(dim=1).sqrt().tolist()
        rows = [row for row, error in enumerate(errors) if self._continues(row, error)]
        if len(rows) < count:
            self.active = [self.active[row] for row in rows]
            self.parameters = [one.detach()[rows].requires_grad_() for one in self.parameters]
            self.moments = [(mean[rows], square[rows]) for mean, square in self.moments]
            self.start = [one[rows] for one in self.start]
        return float(sum(errors)) / count

    def _continues(self, row: int, error: float) -> bool:
        """Record the error of a member; whether it trains on."""
        member, spec = self.active[row], self.spec
        if not (math.isfinite(error) or member.state):
            raise PalpateError(
                f"Training diverged in epoch {self.epoch + 1} at a learning rate of "
                f"{member.rate * spec.learning_rate:g}.",
                "Lower the learning rate.",
                code="training-diverged",
            )
        member.errors.append(error)
        if not spec.keep_best:
            return True
        if error < member.best:
            member.best, member.best_epoch, member.waited = error, self.epoch, 0
            member.state = self._copy(row)
            return True
        member.waited += 1
        if member.waited % (spec.plateau_patience + 1) == 0:
            member.rate *= spec.plateau_factor
        return member.waited < spec.stopping_patience

    def _save(self, path: Path) -> None:
        members = [{**vars(member), "random": member.random.get_state()} for member in self.members]
        active = [row for row, member in enumerate(self.members) if member in self.active]
        own = {name: getattr(self, name) for name in ("epoch", "parameters", "moments")}
        with atomic_write(path) as draft:
            torch.save({**own, "members": members, "active": active, "buffers": list(self.task.buffers)}, draft)

    def _resume(self, path: Path) -> None:
        found = torch.load(path, weights_only=True)
        for member, state in zip(self.members, found["members"], strict=True):
            member.random.set_state(state.pop("random"))
            vars(member).update(state)
        self.active, self.epoch = [self.members[row] for row in found["active"]], found["epoch"]
        self.parameters = [one.requires_grad_() for one in found["parameters"]]
        self.moments = found["moments"]
        self.start = [one[found["active"]] for one in self.start]
        for own, value in zip(self.task.buffers, found["buffers"], strict=True):
            own.copy_(value)


def orthogonalise(matrices: Tensor) -> Tensor:
    """Matrices (r, m, n) with singular values near 1 and the same singular vectors.

    Steps of an odd polynomial of fifth degree, as in the optimiser Muon (Jordan et al. 2024, "Muon: An optimizer for
    hidden layers in neural networks").
    """
    tall = matrices.shape[1] > matrices.shape[2]
    found = matrices.transpose(1, 2) if tall else matrices
    found = found / (found.norm(dim=(1, 2), keepdim=True) + EPSILON)
    first, third, fifth = POLYNOMIAL
    for _ in range(POLYNOMIAL_STEPS):
        square = found @ found.transpose(1, 2)
        square = torch.baddbmm(square, square, square, beta=third, alpha=fifth)
        found = torch.baddbmm(found, square, found, beta=first)
    return found.transpose(1, 2) if tall else found


def add_noise(inputs: Tensor, deviation: float, random: Sequence[Generator]) -> Tensor:
    """Inputs (r, …) with normal noise, of each member from its own stream."""
    noise = torch.empty_like(inputs)
    for part, stream in zip(noise, random, strict=True):
        part.normal_(generator=stream)
    return inputs + deviation * noise
