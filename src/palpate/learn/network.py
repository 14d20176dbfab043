"""Perceptrons trained on images of markers, with jitter drawn again in every epoch."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import torch

from palpate.core import FloatArray
from palpate.learn.spec import TrainingSpec
from palpate.learn.trainer import WARM_UP, TrainedState, Trainer, TrainerSpec, TrainingTask, fall

if TYPE_CHECKING:
    from torch import Generator, Tensor


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


class PerceptronTask(TrainingTask):
    """Perceptrons, their parameters weight (r, in, out) and bias (r, 1, out) of each layer in turn."""

    activation: str
    dropout: float = 0.0

    def forward(self, parameters: list[Tensor], inputs: Tensor, random: Sequence[Generator] | None) -> Tensor:
        activate = torch.relu if self.activation == "relu" else torch.nn.functional.silu
        *inner, weight, bias = parameters
        for inner_weight, inner_bias in zip(inner[0::2], inner[1::2], strict=True):
            inputs = activate(torch.baddbmm(inner_bias, inputs, inner_weight))
            if self.dropout and random is not None:
                kept = draw_uniform(random, inputs.shape[1:]) >= self.dropout
                inputs = inputs * kept / (1.0 - self.dropout)
        return torch.baddbmm(bias, inputs, weight)


class _JitterTask(PerceptronTask):
    """Perceptrons of one seed each, on clean images to which jitter is added."""

    def __init__(self, data: TrainingData, spec: TrainingSpec, random: Sequence[Generator]) -> None:
        def tensor(array: FloatArray) -> Tensor:
            return torch.as_tensor(array, dtype=torch.float32, device=data.device)

        self.activation, self.dropout, self.clean_share = spec.activation, spec.dropout, spec.clean_share
        self.inputs, self.targets = tensor(data.inputs - data.mean), tensor(data.targets)
        self.jitter, self.projection = tensor(data.jitter), tensor(data.projection)
        self.held = tensor((data.held_inputs - data.mean) @ data.projection)[None], tensor(data.held_targets)
        self.rows = torch.arange(len(self.inputs), device=data.device)
        sizes = [data.projection.shape[1], *[spec.width] * spec.layers, data.targets.shape[1]]
        self.parameters = []
        for number, (inward, outward) in enumerate(pairwise(sizes)):  # He et al. 2015, and a small output layer
            spread = math.sqrt(2.0 / inward) if number < spec.layers else 0.1 / math.sqrt(inward)
            drawn = [torch.randn(inward, outward, generator=one, device=data.device) for one in random]
            self.parameters.append((spread * torch.stack(drawn)).requires_grad_())
            self.parameters.append(torch.zeros(len(drawn), 1, outward, device=data.device, requires_grad=True))

    def draw(self, rows: Tensor, done: float, random: Sequence[Generator]) -> tuple[Tensor, Tensor]:
        inputs = self.inputs[rows]
        jittered = round((1.0 - self.clean_share) * rows.shape[1])
        noise = draw_uniform(random, (jittered, inputs.shape[2]))
        inputs[:, :jittered] += (2.0 * noise - 1.0) * self.jitter
        return inputs @ self.projection, self.targets[rows]

    def validation(self) -> Iterable[tuple[Tensor, Tensor]]:
        return [self.held]


def draw_uniform(random: Sequence[Generator], shape: Sequence[int]) -> Tensor:
    """Numbers (r, …) from 0 to 1, of each member from its own stream."""
    drawn = torch.empty(len(random), *shape, device=random[0].device)
    for part, stream in zip(drawn, random, strict=True):
        part.uniform_(generator=stream)
    return drawn


def collect_layers(members: Sequence[TrainedState]) -> tuple[tuple[FloatArray, ...], tuple[FloatArray, ...]]:
    """Weights (r, in, out) and biases (r, out) of each layer of r perceptrons."""
    states = zip(*(member.state for member in members), strict=True)
    layers = [torch.stack(rows).double().cpu().numpy() for rows in states]
    return tuple(layers[0::2]), tuple(bias[:, 0] for bias in layers[1::2])


def train_network(data: TrainingData, spec: TrainingSpec, seeds: Sequence[int]) -> list[TrainedState]:
    """Train one perceptron a seed, all together, on one thread.

    Parameters
    ----------
    data
        Standardised arrays.
    spec
        Shape of the network and schedule.
    seeds
        One a repeat; a repeat's numbers do not depend on the others.

    Raises
    ------
    PalpateError
        If an error stops being a number.
    """
    random, cosine = [torch.Generator(data.device).manual_seed(seed) for seed in seeds], spec.schedule == "cosine"
    trainer = TrainerSpec(
        epochs=spec.epochs,
        batch=spec.batch,
        learning_rate=spec.learning_rate,
        weight_decay=0.0,
        schedule=lambda step, steps: min(1.0, step / WARM_UP) * fall(step / steps) if cosine else 1.0,
        keep_best=not cosine,
        stopping_patience=spec.stopping_patience,
        plateau_patience=spec.plateau_patience,
        plateau_factor=spec.plateau_factor,
    )
    return Trainer(_JitterTask(data, spec, random), trainer, random).run()
