"""Training of a model's parts: ridge in closed form, networks on dots and on pictures by torch, one thread.

Networks are judged on the validation presses after each epoch, and the best epoch's numbers are kept. A network on
pictures writes what it knows after each epoch, so that an interrupted training goes on where it was.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import BoolArray, FloatArray, child_seed, written_whole
from palpate.recording.part import DotsNetwork, LinearPart, PictureNetwork, flat_features

if TYPE_CHECKING:
    pass

PENALTIES = tuple(10.0**k for k in range(-4, 4))
"""Ridge penalties that are tried, over the mean square of a feature and the number of images."""
SIDES = (16, 24, 32)
"""Sizes to which pictures are shrunk for ridge, px."""
COMPONENTS, WIDTH, MEMBERS, DOTS_EPOCHS = 80, 256, 3, 150
"""Network on dots: principal components read, units a layer, members, epochs."""
CHANNELS, DENSE = (16, 32, 64, 96, 128), 256
"""Network on pictures: channels of its convolutions, units of its dense layer."""
BATCH, RATE, DECAY = 32, 2e-3, 2e-2
NOISE = 0.1
"""Noise on pictures while training, over their standard deviation."""


@dataclass(frozen=True, eq=False)
class Lesson:
    """What a part learns from.

    Attributes
    ----------
    inputs
        (n, m, 2) displacements or (n, h, w) pictures.
    targets
        (n, k) poses; of networks that learn all motions, those asked for come first.
    teach, judge
        (n,) images to learn from, and to choose by.
    seed
        Seed of weights and batches.
    """

    inputs: NDArray[Any]
    targets: FloatArray
    teach: BoolArray
    judge: BoolArray
    seed: int = 0

    @property
    def scale(self) -> tuple[FloatArray, FloatArray]:
        """Mean and standard deviation (k,) of the targets that teach."""
        sd = self.targets[self.teach].std(axis=0)
        return self.targets[self.teach].mean(axis=0), np.where(sd > 1e-9, sd, 1.0)

    def error(self, estimates: FloatArray) -> float:
        """Root mean square error of the images that judge, over the targets' standard deviations."""
        return float(np.sqrt(np.mean(((estimates - self.targets[self.judge]) / self.scale[1]) ** 2)))


def fit_ridge_part(name: str, lesson: Lesson, pictures: bool) -> LinearPart:
    """Ridge regression with the penalty, and the size of pictures, that judge best."""
    best, least = None, math.inf
    for side in SIDES if pictures else (None,):
        features = flat_features(lesson.inputs, side)
        for weight, bias in _ridges(features[lesson.teach], lesson):
            error = lesson.error(features[lesson.judge] @ weight + bias)
            if error < least:
                arrays = {"weight": weight.astype(np.float32), "bias": bias}
                least, best = error, arrays | ({} if side is None else {"side": np.array(side)})
    assert best is not None
    return LinearPart(name, best)


def _ridges(features: FloatArray, lesson: Lesson) -> list[tuple[FloatArray, FloatArray]]:
    """Weights (p, k) and biases (k,) for each penalty."""
    mean, _ = lesson.scale
    centre = features.mean(axis=0).astype(float)
    part = features - centre
    values, vectors = np.linalg.eigh(part.T @ part)
    right = vectors.T @ (part.T @ (lesson.targets[lesson.teach] - mean))
    unit = max(float(values.mean()), 1e-12)
    found = []
    for penalty in PENALTIES:
        weight = vectors @ (right / (np.maximum(values, 0.0) + penalty * unit)[:, None])
        found.append((weight, mean - centre @ weight))
    return found


def train_dots_network(name: str, lesson: Lesson) -> DotsNetwork:
    """Perceptrons on principal components of displacements.

    Raises
    ------
    MissingExtraError
        If torch is not installed.
    """
    torch = _torch()
    features = flat_features(lesson.inputs, None)
    taught = features[lesson.teach]
    centre = taught.mean(axis=0)
    values, vectors = np.linalg.eigh(np.cov((taught - centre).T) + 1e-9 * np.eye(taught.shape[1]))
    count = min(COMPONENTS, len(values), max(4, len(taught) // 4))
    values, vectors = np.maximum(values[::-1][:count], 1e-9), vectors[:, ::-1][:, :count]
    projection = vectors / (values / values[0]) ** 0.35 / math.sqrt(values[0])
    mean, sd = lesson.scale
    inputs = torch.as_tensor(((features - centre) @ projection).astype(np.float32))
    targets = torch.as_tensor(((lesson.targets - mean) / sd).astype(np.float32))
    states = []
    for member in range(MEMBERS):
        torch.manual_seed(child_seed(lesson.seed, name, member))
        net = torch.nn.Sequential(
            torch.nn.Linear(count, WIDTH),
            torch.nn.SiLU(),
            torch.nn.Linear(WIDTH, WIDTH),
            torch.nn.SiLU(),
            torch.nn.Linear(WIDTH, targets.shape[1]),
        )
        states.append(_Course(net, lesson, inputs, targets, 0.01, DOTS_EPOCHS).run(None, lambda text: None))
    arrays: dict[str, NDArray[Any]] = {"centre": centre, "projection": projection, "mean": mean, "sd": sd}
    for layer, key in enumerate(("0", "2", "4")):
        arrays[f"weight_{layer}"] = np.stack([state[f"{key}.weight"].numpy().T for state in states])
        arrays[f"bias_{layer}"] = np.stack([state[f"{key}.bias"].numpy() for state in states])
    return DotsNetwork(name, arrays)


def train_picture_network(
    name: str, lesson: Lesson, asked: int, epochs: int, kept: Path, say: Callable[[str], None]
) -> PictureNetwork:
    """A convolutional network on pictures.

    Parameters
    ----------
    name, lesson
        Name of the part, and what it learns from: of its targets the first `asked` are handed on.
    asked, epochs
        Number of targets handed on; passes over the images.
    kept
        File that holds what is known after each epoch; it is removed by who keeps the part.
    say
        Told after each epoch.

    Raises
    ------
    MissingExtraError
        If torch is not installed.
    """
    torch = _torch()
    mean, sd = lesson.scale
    torch.manual_seed(child_seed(lesson.seed, name))
    net = _build_network(torch, lesson.inputs.shape[1:], lesson.targets.shape[1])
    taught = lesson.inputs[lesson.teach]
    level, spread = float(taught.mean()) / 255.0, max(float(taught.std()) / 255.0, 1e-3)
    pictures = torch.as_tensor(lesson.inputs)[:, None]
    targets = torch.as_tensor(((lesson.targets - mean) / sd).astype(np.float32))
    course = _Course(net, lesson, pictures, targets, NOISE, epochs, (level, spread))
    state = course.run(kept, lambda text: say(f"{name}: {text}"))
    arrays = _folded(state, level, spread)
    return PictureNetwork(name, arrays | {"mean": mean, "sd": sd, "asked": np.array(asked)})


def _build_network(torch: Any, size: tuple[int, ...], outputs: int) -> Any:
    layers, inward, side = [], 1, np.array(size)
    for number, outward in enumerate(CHANNELS):
        width = 5 if number == 0 else 3
        layers += [
            torch.nn.Conv2d(inward, outward, width, 2 if number == 0 else 1, width // 2, bias=False),
            torch.nn.BatchNorm2d(outward),
            torch.nn.ReLU(),
        ]
        side = (side + 1) // 2 if number == 0 else side // 2
        layers += [] if number == 0 else [torch.nn.MaxPool2d(2)]
        inward = outward
        if min(side) < 8:
            break
    return torch.nn.Sequential(
        torch.nn.Sequential(*layers),
        torch.nn.Flatten(),
        torch.nn.Linear(inward * int(side.prod()), DENSE),
        torch.nn.ReLU(),
        torch.nn.Dropout(0.1),
        torch.nn.Linear(DENSE, outputs),
    )


def _folded(state: dict[str, Any], level: float, spread: float) -> dict[str, NDArray[Any]]:
    """Arrays of a network with the normalisation of pictures and batches folded into its convolutions."""
    arrays: dict[str, NDArray[Any]] = {}
    numbers = sorted(
        {int(key.split(".")[1]) for key in state if key.startswith("0.") and key.endswith("running_mean")}
    )
    for layer, place in enumerate(numbers):
        own = {
            key: state[f"0.{place}.{key}"].numpy().astype(float)
            for key in ("weight", "bias", "running_mean", "running_var")
        }
        factor = own["weight"] / np.sqrt(own["running_var"] + 1e-5)
        kernel = state[f"0.{place - 1}.weight"].numpy().astype(float)
        arrays[f"kernel_{layer}"] = kernel * factor[:, None, None, None]
        arrays[f"shift_{layer}"] = own["bias"] - own["running_mean"] * factor
    arrays["level"], arrays["spread"] = np.array(level), np.array(spread)
    arrays["dense_0"], arrays["add_0"] = state["2.weight"].numpy(), state["2.bias"].numpy()
    arrays["dense_1"], arrays["add_1"] = state["5.weight"].numpy(), state["5.bias"].numpy()
    return arrays


class _Course:
    """The loop over epochs of one network."""

    def __init__(
        self,
        net: Any,
        lesson: Lesson,
        inputs: Any,
        targets: Any,
        noise: float,
        epochs: int,
        grey: tuple[float, float] | None = None,
    ) -> None:
        self.torch = _torch()
        self.net, self.inputs, self.targets = net, inputs, targets
        self.noise, self.epochs, self.grey = noise, epochs, grey
        self.teach = self.torch.as_tensor(np.flatnonzero(lesson.teach))
        self.judge = self.torch.as_tensor(np.flatnonzero(lesson.judge))
        self.optimiser = self.torch.optim.AdamW(net.parameters(), RATE, weight_decay=DECAY)
        self.best, self.state, self.epoch = math.inf, dict[str, Any](), 0

    def run(self, kept: Path | None, say: Callable[[str], None]) -> dict[str, Any]:
        """Train to the end; what the best epoch knew."""
        threads = self.torch.get_num_threads()
        self.torch.set_num_threads(1)
        try:
            if kept is not None and kept.is_file():
                self._go_on(kept)
            while self.epoch < self.epochs:
                self._train()
                error = self._judge()
                self.epoch += 1
                if error < self.best:
                    self.best = error
                    self.state = {key: value.detach().clone() for key, value in self.net.state_dict().items()}
                if kept is not None:
                    self._keep(kept)
                    say(f"epoch {self.epoch} of {self.epochs}, validation error {error:.4f} of the range's deviation")
        finally:
            self.torch.set_num_threads(threads)
        return self.state

    def _batch(self, rows: Any) -> Any:
        inputs = self.inputs[rows]
        if self.grey is None:
            return inputs
        return (inputs.float() / 255.0 - self.grey[0]) / self.grey[1]

    def _train(self) -> None:
        self.net.train()
        order = self.teach[self.torch.randperm(len(self.teach))]
        batches = [rows for rows in order.split(BATCH) if len(rows) > 1]
        for number, rows in enumerate(batches):
            done = (self.epoch * len(batches) + number + 1) / (self.epochs * len(batches))
            warm = min(1.0, (self.epoch * len(batches) + number + 1) / 200)
            for group in self.optimiser.param_groups:
                group["lr"] = RATE * warm * 0.5 * (1.0 + math.cos(math.pi * done))
            inputs = self._batch(rows)
            inputs = inputs + self.noise * self.torch.randn_like(inputs)
            self.optimiser.zero_grad()
            loss = ((self.net(inputs) - self.targets[rows]) ** 2).mean()
            loss.backward()
            self.optimiser.step()

    def _judge(self) -> float:
        self.net.eval()
        with self.torch.no_grad():
            squares = [
                ((self.net(self._batch(rows)) - self.targets[rows]) ** 2).mean(dim=1) for rows in self.judge.split(64)
            ]
        return float(self.torch.cat(squares).mean().sqrt())

    def _keep(self, path: Path) -> None:
        with written_whole(path) as draft:
            self.torch.save(
                {
                    "net": self.net.state_dict(),
                    "optimiser": self.optimiser.state_dict(),
                    "random": self.torch.get_rng_state(),
                    "best": [self.best, self.epoch],
                    "state": self.state,
                },
                draft,
            )

    def _go_on(self, path: Path) -> None:
        found = self.torch.load(path, weights_only=True)
        self.net.load_state_dict(found["net"])
        self.optimiser.load_state_dict(found["optimiser"])
        self.torch.set_rng_state(found["random"])
        self.best, self.epoch = float(found["best"][0]), int(found["best"][1])
        self.state = found["state"]


def _torch() -> Any:
    from palpate.core import load_extra

    return load_extra("torch", "learn")
