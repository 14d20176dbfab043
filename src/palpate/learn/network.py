"""Perceptrons trained on images of markers, with jitter drawn again in every epoch."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import torch

from palpate.core import FloatArray, child_seed
from palpate.learn.components import PrincipalComponents
from palpate.learn.spec import TrainingSpec
from palpate.learn.trainer import TrainedState, Trainer, TrainerSpec, TrainingTask, fall_from_warm_up
from palpate.learn.training_set import TrainingSet

if TYPE_CHECKING:
    from torch import Generator, Tensor


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

    def __init__(
        self, samples: TrainingSet, jitter: FloatArray, inside: PrincipalComponents, spec: TrainingSpec, device: str
    ) -> None:
        def tensor(array: FloatArray) -> Tensor:
            return torch.as_tensor(array, dtype=torch.float32, device=device)

        self.activation, self.dropout, self.clean_share = spec.activation, spec.dropout, spec.clean_share
        centred, targets = samples.inputs - inside.mean, samples.standardised
        train, validation = samples.train, samples.validation
        self.inputs, self.targets = tensor(centred[train]), tensor(targets[train])
        self.jitter, self.projection = tensor(jitter), tensor(inside.projection)
        self.held = tensor(centred[validation] @ inside.projection)[None], tensor(targets[validation])
        self.rows = torch.arange(len(self.inputs), device=device)
        self.random = [
            torch.Generator(device).manual_seed(child_seed(samples.seed, "repeat", n)) for n in range(spec.repeats)
        ]
        sizes = [inside.projection.shape[1], *[spec.width] * spec.layers, targets.shape[1]]
        self.parameters = []
        for number, (inward, outward) in enumerate(pairwise(sizes)):  # He et al. 2015, and a small output layer
            spread = math.sqrt(2.0 / inward) if number < spec.layers else 0.1 / math.sqrt(inward)
            drawn = [torch.randn(inward, outward, generator=one, device=device) for one in self.random]
            self.parameters.append((spread * torch.stack(drawn)).requires_grad_())
            self.parameters.append(torch.zeros(len(drawn), 1, outward, device=device, requires_grad=True))
        self.matrices = range(0, 2 * spec.layers, 2)

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


def train_network(
    samples: TrainingSet, jitter: FloatArray, inside: PrincipalComponents, spec: TrainingSpec, device: str = "cpu"
) -> list[TrainedState]:
    """Train the repeats of a perceptron, all together, on one thread.

    Parameters
    ----------
    samples
        Normalised images (n, 2m), clean for training and with jitter for validation, and poses; the numbers of a
        repeat do not depend on further repeats.
    jitter
        (2m,) half-width of the uniform jitter, normalised.
    inside
        Components that the network reads.
    spec
        Shape of the network and schedule.
    device
        ``"cpu"`` or ``"cuda"``: place of tensors and random streams; another device draws other numbers.

    Raises
    ------
    PalpateError
        If an error is not a number.
    """
    task, cosine = _JitterTask(samples, jitter, inside, spec, device), spec.schedule == "cosine"
    trainer = TrainerSpec(
        epochs=spec.epochs,
        batch=spec.batch,
        learning_rate=spec.learning_rate,
        matrix_rate=spec.matrix_rate,
        weight_decay=0.0,
        schedule=fall_from_warm_up if cosine else lambda step, steps: 1.0,
        keep_best=not cosine,
        stopping_patience=spec.stopping_patience,
        plateau_patience=spec.plateau_patience,
        plateau_factor=spec.plateau_factor,
    )
    return Trainer(task, trainer, task.random).run()
