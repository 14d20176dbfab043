"""The course of a network's training: epochs on one lesson, the best of them kept, and what goes on after a break.

After each epoch the network is judged on the presses that choose, and the numbers of the best epoch are handed on.
What is known is written every few seconds, so that an interrupted training goes on where it was.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from palpate.core import atomic_write, load_extra
from palpate.core.run import Progress
from palpate.learn.training_set import TrainingSet

_WARM_UP = 200
_BETWEEN_S = 5.0
IMAGE_S = 0.01
"""Time of one core to train on one image, s: a network that sees 250 000 images takes 35 to 50 minutes."""


def load_torch() -> Any:
    """PyTorch.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    return load_extra("torch", "learn")


def _has_short_floats(torch: Any) -> bool:
    """Whether the processor itself multiplies numbers of 16 bit, with which pictures are learnt twice as fast."""
    return bool(getattr(torch.cpu, "_is_avx512_bf16_supported", lambda: False)())


@dataclass(frozen=True)
class TrainerSpec:
    """How a network is trained.

    Attributes
    ----------
    epochs, batch, learning_rate, weight_decay
        Passes, images of a batch, learning rate of AdamW (cosine, after a short rise), weight decay.
    noise
        Standard deviation of noise on the inputs while training.
    grey
        Mean and spread by which pictures of 8 bit, over 255, are normalised; `None` for inputs that are.
    shift
        Most px by which pictures are shifted at random while training: one shift a batch.
    warm_up_share
        Share of the training in which the rate rises; 0 for a short rise.
    anchor_weight
        Pull of the weights towards where they began.
    threads
        Cores that it may use.
    augment
        Draws inputs and targets of a batch from its rows, the share of the training that is over, and a generator;
        `None` takes them as they are.
    """

    epochs: int
    batch: int = 32
    learning_rate: float = 2e-3
    weight_decay: float = 2e-2
    noise: float = 0.0
    grey: tuple[float, float] | None = None
    shift: int = 0
    warm_up_share: float = 0.0
    anchor_weight: float = 0.0
    threads: int = 1
    augment: Callable[[Any, float, Any], tuple[Any, Any]] | None = None


class Trainer:
    """The loop over epochs of one network, on standardised targets; `random` draws batches, noise and shifts."""

    def __init__(
        self, net: Any, lesson: TrainingSet, inputs: Any, targets: Any, spec: TrainerSpec, random: Any
    ) -> None:
        self.torch, self.random = load_torch(), random
        self.net, self.inputs, self.targets, self.spec = net, inputs, targets, spec
        self.short = spec.grey is not None and _has_short_floats(self.torch)
        if spec.grey is not None:
            net.to(memory_format=self.torch.channels_last)
        self.train_rows = self.torch.as_tensor(np.flatnonzero(lesson.train))
        self.validation_rows = self.torch.as_tensor(np.flatnonzero(lesson.validation))
        self.optimiser = self.torch.optim.AdamW(net.parameters(), spec.learning_rate, weight_decay=spec.weight_decay)
        self.begin = [value.detach().clone() for value in net.parameters()] if spec.anchor_weight else []
        self.best, self.state, self.epoch = math.inf, dict[str, Any](), 0

    def run(
        self, checkpoint: Path | None = None, progress: Progress | None = None, what: str = "network"
    ) -> dict[str, Any]:
        """Train to the end; what the best epoch knew.

        Parameters
        ----------
        checkpoint
            File that holds what is known now and then; `None` keeps nothing.
        progress, what
            Receives each epoch of the network `what`; its cost is that of its images.
        """
        threads, saved = self.torch.get_num_threads(), time.monotonic()
        self.torch.set_num_threads(self.spec.threads)
        try:
            if checkpoint is not None and checkpoint.is_file():
                self._go_on(checkpoint)
            cost = IMAGE_S * len(self.train_rows)
            if progress is not None:
                progress.begin(what, self.spec.epochs * cost, self.epoch * cost)
            while self.epoch < self.spec.epochs:
                self._train()
                error = self._validate()
                self.epoch += 1
                if error < self.best or not self.state:
                    self.best = error
                    self.state = {key: value.detach().clone() for key, value in self.net.state_dict().items()}
                if checkpoint is not None and time.monotonic() - saved > _BETWEEN_S:
                    self._keep(checkpoint)
                    saved = time.monotonic()
                if progress is not None:
                    text = f"epoch {self.epoch} of {self.spec.epochs}, validation error {error:.4f} of the deviation"
                    progress.advance(what, self.epoch * cost, text)
            if progress is not None:
                progress.finish(what)
        finally:
            self.torch.set_num_threads(threads)
        return self.state

    def _normal(self, inputs: Any) -> Any:
        grey = self.spec.grey
        if grey is None:
            return inputs
        return ((inputs.float() / 255.0 - grey[0]) / grey[1]).contiguous(memory_format=self.torch.channels_last)

    def _rate(self, step: int, steps: int) -> float:
        rise = self.spec.warm_up_share * steps
        if step < rise:
            return self.spec.learning_rate * step / rise
        fall = 0.5 * (1.0 + math.cos(math.pi * (step - rise) / (steps - rise)))
        return self.spec.learning_rate * fall * (1.0 if rise else min(1.0, step / min(_WARM_UP, 0.2 * steps + 1)))

    def _shifted(self, inputs: Any) -> Any:
        most, grey = self.spec.shift, self.spec.grey
        if not most or grey is None:
            return inputs
        height, width = inputs.shape[-2:]
        padded = self.torch.nn.functional.pad(inputs, (most,) * 4, value=-grey[0] / grey[1])
        down, right = self.torch.randint(0, 2 * most + 1, (2,), generator=self.random).tolist()
        return padded[..., down : down + height, right : right + width]

    def _draw(self, rows: Any, over: float) -> tuple[Any, Any]:
        vary = self.spec.augment
        inputs, targets = (self.inputs[rows], self.targets[rows]) if vary is None else vary(rows, over, self.random)
        return self._shifted(self._normal(inputs)), targets

    def _noise(self, inputs: Any) -> Any:
        """Standard normal numbers in the shape and order in memory of inputs."""
        return self.torch.empty_like(inputs).normal_(generator=self.random)

    def _train(self) -> None:
        self.net.train()
        order = self.train_rows[self.torch.randperm(len(self.train_rows), generator=self.random)]
        batches = [rows for rows in order.split(self.spec.batch) if len(rows) > 1]
        steps = max(self.spec.epochs * len(batches), 1)
        for number, rows in enumerate(batches):
            step = self.epoch * len(batches) + number + 1
            for group in self.optimiser.param_groups:
                group["lr"] = self._rate(step, steps)
            inputs, targets = self._draw(rows, step / steps)
            inputs = inputs + self.spec.noise * self._noise(inputs)
            self.optimiser.zero_grad()
            with self.torch.autocast("cpu", self.torch.bfloat16, enabled=self.short):
                found = self.net(inputs).float()
            loss = ((found - targets) ** 2).mean()
            for now, before in zip(self.net.parameters(), self.begin, strict=False):
                loss = loss + self.spec.anchor_weight * ((now - before) ** 2).sum()
            loss.backward()
            self.optimiser.step()

    def _validate(self) -> float:
        self.net.eval()
        with self.torch.no_grad():
            squares = [
                ((self.net(self._normal(self.inputs[rows])) - self.targets[rows]) ** 2).mean(dim=1)
                for rows in self.validation_rows.split(64)
            ]
        return float(self.torch.cat(squares).mean().sqrt())

    def _keep(self, path: Path) -> None:
        with atomic_write(path) as draft:
            self.torch.save(
                {
                    "net": self.net.state_dict(),
                    "optimiser": self.optimiser.state_dict(),
                    "random": self.random.get_state(),
                    "best": [self.best, self.epoch],
                    "state": self.state,
                },
                draft,
            )

    def _go_on(self, path: Path) -> None:
        found = self.torch.load(path, weights_only=True)
        self.net.load_state_dict(found["net"])
        self.optimiser.load_state_dict(found["optimiser"])
        self.random.set_state(found["random"])
        self.best, self.epoch = float(found["best"][0]), int(found["best"][1])
        self.state = found["state"]
