"""Several multilayer perceptrons trained as one: every repeat is a slice of the same batched matrices.

Weights have the shape (r, in, out), so one product serves all repeats; each has its own seed for weights, order
of images, jitter and dropout, its own learning rate, and stops by itself. This is the only file that trains.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING

from palpate.core import FloatArray, MissingExtraError, PalpateError
from palpate.learn.spec import TrainingSpec

try:
    import torch
except ImportError as error:  # pragma: no cover - exercised in a process without torch
    raise MissingExtraError("torch", "learn") from error

if TYPE_CHECKING:
    from torch import Tensor


BETA_1, BETA_2, EPSILON = 0.9, 0.999, 1e-8
"""Adam's constants (Kingma & Ba 2015)."""
WARM_UP = 200
"""Batches over which the learning rate of the cosine schedule rises from near zero."""


@dataclass(frozen=True)
class TrainingData:
    """Arrays of one training; the network reads (inputs + jitter − mean) · projection.

    Attributes
    ----------
    inputs, targets
        (n, 2m) normalised clean images and (n, 3) standardised poses to train on.
    jitter
        (2m,) half-width of the uniform jitter, normalised.
    mean, projection
        (2m,) and (2m, k): see `components`.
    held_inputs, held_targets
        The same of the validation images, jitter already drawn.
    device
        ``"cpu"`` or ``"cuda"``: where tensors and random streams live; another device draws other numbers.
    """

    inputs: FloatArray
    targets: FloatArray
    jitter: FloatArray
    mean: FloatArray
    projection: FloatArray
    held_inputs: FloatArray
    held_targets: FloatArray
    device: str = "cpu"


@dataclass(frozen=True)
class TrainedNetwork:
    """Weights of every repeat, and how they came about.

    Attributes
    ----------
    weights, biases
        One (r, in, out) and one (r, out) a layer.
    history
        For each repeat, the validation error (root mean square of standardised poses) after each epoch.
    best_epoch
        For each repeat, the epoch (from 0) whose weights were kept.
    """

    weights: tuple[FloatArray, ...]
    biases: tuple[FloatArray, ...]
    history: tuple[tuple[float, ...], ...]
    best_epoch: tuple[int, ...]


def train_network(data: TrainingData, spec: TrainingSpec, seeds: Sequence[int]) -> TrainedNetwork:
    """Train one perceptron a seed, all together, on one thread.

    Parameters
    ----------
    data
        Standardised arrays.
    spec
        Shape of the network and schedule.
    seeds
        One a repeat; a repeat's numbers do not depend on the others.

    Returns
    -------
    TrainedNetwork
        Weights in the order of `seeds`.

    Raises
    ------
    PalpateError
        If an error stops being a number.
    """
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        return _Training(data, spec, seeds).run()
    finally:
        torch.set_num_threads(threads)


@dataclass
class _Repeat:
    """One repeat: its random stream, its schedule, the best weights so far."""

    generator: torch.Generator
    rate: float
    best: float = math.inf
    best_epoch: int = -1
    waited: int = 0
    weights: list[Tensor] = field(default_factory=list)
    errors: list[float] = field(default_factory=list)


class _Training:
    """The loop over epochs. `active` lists the repeats that still train, in the order of the tensors' rows."""

    def __init__(self, data: TrainingData, spec: TrainingSpec, seeds: Sequence[int]) -> None:
        def tensor(array: FloatArray) -> Tensor:
            return torch.as_tensor(array, dtype=torch.float32, device=data.device)

        self.spec, self.device = spec, data.device
        self.inputs, self.targets = tensor(data.inputs - data.mean), tensor(data.targets)
        self.jitter, self.projection = tensor(data.jitter), tensor(data.projection)
        self.held = tensor((data.held_inputs - data.mean) @ data.projection), tensor(data.held_targets)
        streams = [torch.Generator(self.device).manual_seed(seed) for seed in seeds]
        self.repeats = [_Repeat(stream, spec.learning_rate) for stream in streams]
        self.active = list(self.repeats)
        self.parameters = self._start_weights()
        self.moments = [(torch.zeros_like(p), torch.zeros_like(p)) for p in self.parameters]
        self.steps = 0
        self.batches = math.ceil(len(self.inputs) / spec.batch)

    def run(self) -> TrainedNetwork:
        """Train every repeat until it stops or the epochs are spent."""
        for epoch in range(self.spec.epochs):
            self._train_epoch()
            self._validate(epoch)
            if not self.active:
                break
        for row, repeat in enumerate(self.active):
            if self.spec.schedule == "cosine" or not repeat.weights:
                repeat.weights = [p[row].detach().clone() for p in self.parameters]
                repeat.best_epoch = len(repeat.errors) - 1
        layers = [
            torch.stack(rows).double().cpu().numpy() for rows in zip(*(r.weights for r in self.repeats), strict=True)
        ]
        return TrainedNetwork(
            weights=tuple(layers[0::2]),
            biases=tuple(bias[:, 0] for bias in layers[1::2]),
            history=tuple(tuple(repeat.errors) for repeat in self.repeats),
            best_epoch=tuple(repeat.best_epoch for repeat in self.repeats),
        )

    def _start_weights(self) -> list[Tensor]:
        """Weights of He et al. 2015, a small output layer, zero biases; weight and bias of each layer in turn."""
        sizes = [self.projection.shape[1], *[self.spec.width] * self.spec.layers, self.targets.shape[1]]
        parameters = []
        for number, (inward, outward) in enumerate(pairwise(sizes)):
            spread = math.sqrt(2.0 / inward) if number < self.spec.layers else 0.1 / math.sqrt(inward)
            drawn = [torch.randn(inward, outward, generator=r.generator, device=self.device) for r in self.active]
            parameters.append((spread * torch.stack(drawn)).requires_grad_())
            parameters.append(torch.zeros(len(drawn), 1, outward, device=self.device, requires_grad=True))
        return parameters

    def _train_epoch(self) -> None:
        count = len(self.inputs)
        drawn = [torch.randperm(count, generator=r.generator, device=self.device) for r in self.active]
        order = torch.stack(drawn)
        for chosen in torch.split(order, self.spec.batch, dim=1):
            inputs = self.inputs[chosen]
            jittered = round((1.0 - self.spec.clean_share) * chosen.shape[1])
            noise = self._uniform(jittered, inputs.shape[2])
            inputs[:, :jittered] += (2.0 * noise - 1.0) * self.jitter
            outputs = self._forward(inputs @ self.projection, dropout=self.spec.dropout)
            # the sum over repeats keeps each one's gradient its own
            loss = ((outputs - self.targets[chosen]) ** 2).mean(dim=(1, 2)).sum()
            gradients = torch.autograd.grad(loss, self.parameters)
            self._step(gradients)

    def _uniform(self, rows: int, columns: int) -> Tensor:
        drawn = torch.empty(len(self.active), rows, columns, device=self.device)
        for slice_, repeat in zip(drawn, self.active, strict=True):
            torch.rand(rows, columns, generator=repeat.generator, out=slice_)
        return drawn

    def _forward(self, hidden: Tensor, dropout: float = 0.0) -> Tensor:
        activate = torch.nn.functional.silu if self.spec.activation == "silu" else torch.relu
        *inner, weight, bias = self.parameters
        for inner_weight, inner_bias in zip(inner[0::2], inner[1::2], strict=True):
            hidden = activate(torch.baddbmm(inner_bias, hidden, inner_weight))
            if dropout:
                kept = self._uniform(hidden.shape[1], hidden.shape[2]) >= dropout
                hidden = hidden * kept / (1.0 - dropout)
        return torch.baddbmm(bias, hidden, weight)

    @torch.no_grad()
    def _step(self, gradients: Sequence[Tensor]) -> None:
        """One step of Adam with a learning rate a repeat."""
        self.steps += 1
        factor = 1.0
        if self.spec.schedule == "cosine":
            done = self.steps / (self.spec.epochs * self.batches)
            factor = min(1.0, self.steps / WARM_UP) * 0.5 * (1.0 + math.cos(math.pi * done))
        rates = torch.tensor([factor * repeat.rate for repeat in self.active], device=self.device)[:, None, None]
        rates = rates / (1.0 - BETA_1**self.steps)
        for parameter, gradient, (mean, square) in zip(self.parameters, gradients, self.moments, strict=True):
            mean.lerp_(gradient, 1.0 - BETA_1)
            square.mul_(BETA_2).addcmul_(gradient, gradient, value=1.0 - BETA_2)
            size = (square / (1.0 - BETA_2**self.steps)).sqrt_().add_(EPSILON)
            parameter.sub_(rates * mean / size)

    @torch.no_grad()
    def _validate(self, epoch: int) -> None:
        """Measure the validation error of each repeat; on a plateau drop rates and stop."""
        inputs, targets = self.held
        outputs = self._forward(inputs.expand(len(self.active), *inputs.shape))
        errors = ((outputs - targets) ** 2).mean(dim=(1, 2)).sqrt().tolist()
        going = []
        for row, (repeat, error) in enumerate(zip(self.active, errors, strict=True)):
            if not math.isfinite(error):
                raise PalpateError(
                    f"Training diverged in epoch {epoch + 1} at a learning rate of {repeat.rate:g}.",
                    "Lower the learning rate.",
                    code="training-diverged",
                )
            repeat.errors.append(error)
            if self.spec.schedule == "cosine" or self._goes_on(repeat, row, error, epoch):
                going.append(row)
        if len(going) < len(self.active):
            self._keep(going)

    def _goes_on(self, repeat: _Repeat, row: int, error: float, epoch: int) -> bool:
        if error < repeat.best:
            repeat.best, repeat.best_epoch, repeat.waited = error, epoch, 0
            repeat.weights = [p[row].detach().clone() for p in self.parameters]
            return True
        repeat.waited += 1
        if repeat.waited % (self.spec.plateau_patience + 1) == 0:
            repeat.rate *= self.spec.plateau_factor
        return repeat.waited < self.spec.stopping_patience

    def _keep(self, rows: list[int]) -> None:
        """Go on with some of the active repeats."""
        self.active = [self.active[row] for row in rows]
        self.parameters = [p.detach()[rows].requires_grad_() for p in self.parameters]
        self.moments = [(mean[rows], square[rows]) for mean, square in self.moments]
