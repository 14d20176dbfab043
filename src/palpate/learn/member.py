"""Kinds of estimators: each is trained on samples, and estimates from displacements or images.

An installed package adds a kind by an entry point in the group ``palpate.estimators``. `palpate recording train` then
trains it with the kinds of palpate, and it may become a part of the model.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Literal, Self, final

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, Registry, load_extra
from palpate.core.run import Progress
from palpate.learn.gaussian_process import FEWEST_ROWS, move_features, predict_process, train_process
from palpate.learn.graph import image_graph, open_session
from palpate.learn.motion_model import SimulatedMotion, draw_poses, fit_motion
from palpate.learn.perceptron import evaluate_perceptrons
from palpate.learn.ridge import solve_ridge
from palpate.learn.training_set import TrainingSet, flat_features

EFFORTS = ("ridge", "fast", "all")
"""Choices of `RecordingSpec.estimators` by effort, ascending: closed forms, minutes, an hour."""
PENALTIES = tuple(10.0**k for k in range(-4, 4))
"""Ridge penalties that are tried, over the mean square of a feature and the number of images."""
SIDES = (16, 24, 32)
"""Sizes to which images are shrunk for ridge, px. By hand."""
_LONGER = 8 / 3
"""Ratio of passes over rotated and plain images: augmented data allow longer training. By hand."""
_MOST_SHOWN = 250_000
"""Images that these passes show at most, unless plain ones show more: 35 to 50 minutes of a core."""
_ADDED = "added_"
"""Prefix of the arrays of a process that is added to another one."""
_IMAGE_S, _MARKERS_S = 0.01, 60.0
"""Time of one core for one image, and for a network on markers, s: decides only the remaining time."""


@dataclass(frozen=True)
class TrainingRun:
    """Means of a training.

    Attributes
    ----------
    epochs
        Passes over images as they are; kinds that read displacements choose their own.
    threads
        Cores that it may use.
    checkpoint
        File of the state of an interrupted training, which is resumed; `None` for no file.
    progress
        Receives each epoch.
    """

    epochs: int = 60
    threads: int = 1
    checkpoint: Path | None = None
    progress: Progress = field(default_factory=Progress)


@dataclass(frozen=True, eq=False)
class EnsembleMember(ABC):
    """One trained estimator.

    Attributes
    ----------
    kind
        Name of the class in `ESTIMATORS`, also in files.
    reads_markers
        Whether it reads displacements of markers, (n, m, 2) px; else images, (n, h, w) of 8 bit.
    effort
        One of `EFFORTS`: the first choice of `RecordingSpec.estimators` that trains it.
    takes_rotation, takes_auxiliary
        Whether it is trained a second time with rotated presses, and with further motions as targets.
    uses_validation
        Whether it makes choices on the validation samples.
    name
        Such as ``dots-network-turned``: its kind, and how it was trained.
    arrays
        All its numbers, by name.
    """

    kind: ClassVar[str]
    reads_markers: ClassVar[bool]
    effort: ClassVar[Literal["ridge", "fast", "all"]] = "fast"
    takes_rotation: ClassVar[bool] = False
    takes_auxiliary: ClassVar[bool] = False
    uses_validation: ClassVar[bool] = True
    name: str
    arrays: dict[str, NDArray[Any]]

    @classmethod
    @abstractmethod
    def train(cls, name: str, samples: TrainingSet, run: TrainingRun) -> Self:
        """Train on samples; equal seeds give equal numbers."""

    @abstractmethod
    def predict(self, inputs: NDArray[Any]) -> FloatArray:
        """Poses (n, k) of displacements or images (n, ...)."""

    @classmethod
    def suits(cls, samples: TrainingSet) -> bool:
        """Whether it can be trained on samples, and may be better than other kinds."""
        return True

    @classmethod
    def passes(cls, samples: TrainingSet, epochs: int) -> int:
        """Passes over the training samples, if the user chooses them; else 0."""
        return 0

    @classmethod
    def cost(cls, samples: TrainingSet, epochs: int) -> float:
        """Expected time of one core, s; 0 for a closed form."""
        return 0.0 if cls.effort == "ridge" else _MARKERS_S


class _Ridge(EnsembleMember):
    """Ridge regression, with penalty and image size of minimum validation error."""

    effort = "ridge"
    sides: ClassVar[Sequence[int | None]] = (None,)

    @classmethod
    def train(cls, name: str, samples: TrainingSet, run: TrainingRun) -> Self:
        best: dict[str, NDArray[Any]] = {}
        least = math.inf
        for side in cls.sides:
            features = flat_features(samples.inputs, side)
            train = features[samples.train]
            unit = max(float(train.var(axis=0, dtype=float).mean()) * len(train), 1e-12)
            fits = solve_ridge(train, samples.targets[samples.train], [unit * one for one in PENALTIES])
            for weight, bias in fits:
                error = samples.error(features[samples.chosen_by] @ weight + bias)
                if error < least:
                    least, best = error, {"weight": weight.astype(np.float32), "bias": bias}
                    best |= {} if side is None else {"side": np.array(side)}
        return cls(name, best)

    def predict(self, inputs: NDArray[Any]) -> FloatArray:
        side = int(self.arrays["side"]) if "side" in self.arrays else None
        return np.asarray(flat_features(inputs, side) @ self.arrays["weight"] + self.arrays["bias"], float)


@final
class MarkerRidge(_Ridge):
    """Ridge regression on displacements."""

    kind = "dots-ridge"
    reads_markers = True


@final
class ImageRidge(_Ridge):
    """Ridge regression on images shrunk to `side` px."""

    kind = "picture-ridge"
    reads_markers = False
    sides = SIDES


class MarkerProcess(EnsembleMember):
    """A Gaussian process on displacements: the best estimator of some 30 to 1 000 presses."""

    kind = "dots-process"
    reads_markers = True
    effort = "ridge"
    takes_rotation = True
    uses_validation = False

    @classmethod
    def train(cls, name: str, samples: TrainingSet, run: TrainingRun) -> Self:
        return cls(name, train_process(samples))

    def transform_inputs(self, matrix: FloatArray) -> MarkerProcess:
        """Return this process for displacements (p,) that `matrix` (p, q) maps to its own."""
        mapped = {key: matrix @ one for key, one in self.arrays.items() if key.endswith("projection")}
        return MarkerProcess(self.name, self.arrays | mapped)

    def transform_outputs(self, name: str, turn: FloatArray, shift: FloatArray) -> MarkerProcess:
        """A process whose outputs are y · turn (k, l) + shift (l,)."""
        arrays = dict(self.arrays)
        for number, prefix in enumerate(self._prefixes):
            before, offset = arrays.get(f"{prefix}turn"), arrays.get(f"{prefix}shift", np.zeros(len(turn)))
            arrays[f"{prefix}turn"] = turn if before is None else before @ turn
            arrays[f"{prefix}shift"] = offset @ turn + (shift if number == 0 else 0.0)
        return MarkerProcess(name, arrays)

    def fine_tune(self, name: str, samples: TrainingSet) -> MarkerProcess:
        """Add a process of the errors of this one on the samples."""
        errors = replace(samples, targets=samples.targets - self.predict(samples.inputs), rotation=None)
        prefix = f"{_ADDED}{len(self._prefixes)}_"
        return MarkerProcess(
            name, self.arrays | {f"{prefix}{key}": one for key, one in train_process(errors).items()}
        )

    def predict(self, inputs: NDArray[Any]) -> FloatArray:
        found = []
        for arrays in self._processes:
            own = predict_process(arrays, inputs)
            found.append(own @ arrays["turn"] + arrays["shift"] if "turn" in arrays else own)
        return np.asarray(np.sum(found, axis=0))

    @property
    def _prefixes(self) -> list[str]:
        """Prefixes of the arrays of the process and of those that were added to it."""
        count = sum(key.startswith(_ADDED) and key.endswith("_projection") for key in self.arrays)
        return ["", *(f"{_ADDED}{number}_" for number in range(1, count + 1))]

    @cached_property
    def _processes(self) -> list[dict[str, NDArray[Any]]]:
        """Arrays of each process, with the features under each element of the group."""
        found = []
        for prefix in self._prefixes:
            mine = {key.removeprefix(prefix): one for key, one in self.arrays.items() if key.startswith(prefix)}
            arrays = {key: one for key, one in mine.items() if not key.startswith(_ADDED)}
            found.append(arrays | {"moved": move_features(arrays)})
        return found


@final
class MotionProcess(MarkerProcess):
    """A Gaussian process trained on draws of a `MotionModel`: the best estimator of some ten presses."""

    kind = "dots-motion"

    @classmethod
    def suits(cls, samples: TrainingSet) -> bool:
        return samples.rotation is not None and samples.train.sum() <= FEWEST_ROWS

    @classmethod
    def train(cls, name: str, samples: TrainingSet, run: TrainingRun) -> Self:
        return cls.of_motion(name, samples)

    @classmethod
    def of_motion(cls, name: str, samples: TrainingSet, simulation: SimulatedMotion | None = None) -> Self:
        """Train on draws from the motion model of samples, which corrects a simulation if one is given."""
        model = fit_motion(samples, simulation)
        poses = draw_poses(samples.targets[samples.train], samples.seed)
        every = np.ones(len(poses), bool)
        fields = model.draw(poses, samples.seed)
        drawn = TrainingSet(fields, poses, every, ~every, samples.seed, samples.rotation)
        found = cls(name, train_process(drawn, doubtful=False))
        # a broken symmetry, such as by the tilt of the camera, shifts all estimates alike
        left = samples.targets[samples.train] - found.predict(samples.inputs[samples.train])
        shifted = found.transform_outputs(name, np.eye(left.shape[1]), left.mean(axis=0))
        return cls(name, shifted.arrays)


@final
class MarkerNetwork(EnsembleMember):
    """Perceptrons on principal components of displacements, averaged."""

    kind = "dots-network"
    reads_markers = True
    takes_rotation = True

    @classmethod
    def train(cls, name: str, samples: TrainingSet, run: TrainingRun) -> Self:
        load_extra("torch", "learn")
        from palpate.learn.train_member import train_marker_network

        run.progress.begin(name, cls.cost(samples, run.epochs))
        arrays = train_marker_network(name, samples, checkpoint=run.checkpoint)
        run.progress.finish(name)
        return cls(name, arrays)

    def transform_inputs(self, matrix: FloatArray) -> MarkerNetwork:
        """Return these networks for displacements (p,) that `matrix` (p, q) maps to their own."""
        return MarkerNetwork(self.name, {**self.arrays, "projection": matrix @ self.arrays["projection"]})

    def transform_outputs(self, name: str, turn: FloatArray, shift: FloatArray) -> MarkerNetwork:
        """Networks whose outputs are y · turn (k, l) + shift (l,)."""
        arrays = dict(self.arrays)
        last = max(int(key[7:]) for key in arrays if key.startswith("weight_"))
        mean, sd = arrays["mean"] @ turn + shift, np.sqrt(arrays["sd"] ** 2 @ turn**2)
        factor = arrays["sd"][:, None] * turn / sd
        arrays[f"weight_{last}"] = arrays[f"weight_{last}"] @ factor
        arrays[f"bias_{last}"] = arrays[f"bias_{last}"] @ factor
        return MarkerNetwork(name, arrays | {"mean": mean, "sd": sd})

    def fine_tune(self, name: str, samples: TrainingSet) -> MarkerNetwork:
        """Train these networks further, regularised towards their weights; inputs are those of `samples`."""
        load_extra("torch", "learn")
        from palpate.learn.train_member import fine_tune_marker_network

        return MarkerNetwork(name, fine_tune_marker_network(name, samples, self.arrays))

    def predict(self, inputs: NDArray[Any]) -> FloatArray:
        found = self.arrays
        features = flat_features(inputs, None) @ found["projection"] - found["offset"]
        layers = range(sum(name.startswith("weight_") for name in found))
        weights, biases = ([found[f"{kind}_{number}"] for number in layers] for kind in ("weight", "bias"))
        outputs = evaluate_perceptrons(features, weights, biases, "relu" if "relu" in found else "silu")
        return np.asarray(outputs.mean(axis=0) * found["sd"] + found["mean"], float)


@final
class ImageNetwork(EnsembleMember):
    """A convolutional network on images; auxiliary outputs are left out."""

    kind = "picture-network"
    reads_markers = False
    effort = "all"
    takes_rotation = takes_auxiliary = True

    @classmethod
    def passes(cls, samples: TrainingSet, epochs: int) -> int:
        if samples.rotation is None:
            return epochs
        return max(epochs, min(round(_LONGER * epochs), _MOST_SHOWN // max(int(samples.train.sum()), 1)))

    @classmethod
    def cost(cls, samples: TrainingSet, epochs: int) -> float:
        return _IMAGE_S * cls.passes(samples, epochs) * int(samples.train.sum())

    @classmethod
    def train(cls, name: str, samples: TrainingSet, run: TrainingRun) -> Self:
        load_extra("torch", "learn")
        from palpate.learn.train_member import ImageTask
        from palpate.learn.trainer import Trainer

        task = ImageTask(name, samples)
        trainer = Trainer(task, task.spec(cls.passes(samples, run.epochs), run.threads), task.random)
        [found] = trainer.run(run.checkpoint, run.progress, name, cls.cost(samples, run.epochs))
        mean, sd = samples.scale
        arrays = {"mean": mean, "sd": sd, "asked": np.array(samples.n_outputs)}
        return cls(name, task.fold(found.state) | arrays)

    @cached_property
    def _session(self) -> Any:
        return open_session(image_graph(self.arrays))

    def predict(self, inputs: NDArray[Any]) -> FloatArray:
        session, parts = self._session, []
        for start in range(0, len(inputs), 64):
            batch = inputs[start : start + 64, None].astype(np.float32) / np.float32(255)
            parts.append(session.run(None, {"picture": batch})[0])
        found = np.concatenate(parts) if parts else np.zeros((0, len(self.arrays["mean"])))
        count = int(self.arrays["asked"])
        return np.asarray(found * self.arrays["sd"] + self.arrays["mean"], float)[:, :count]


ESTIMATORS: Registry[type[EnsembleMember]] = Registry(
    "palpate.estimators",
    "estimator",
    {
        "picture-ridge": "palpate.learn.member:ImageRidge",
        "dots-ridge": "palpate.learn.member:MarkerRidge",
        "dots-process": "palpate.learn.member:MarkerProcess",
        "dots-motion": "palpate.learn.member:MotionProcess",
        "dots-network": "palpate.learn.member:MarkerNetwork",
        "picture-network": "palpate.learn.member:ImageNetwork",
    },
    lambda found: isinstance(found, type) and issubclass(found, EnsembleMember),
)
"""Kinds of estimators by name."""


def open_member(kind: str, name: str, arrays: dict[str, NDArray[Any]]) -> EnsembleMember:
    """A member from its numbers in a file; files of 0.2 call both ridges ``linear``."""
    if kind == "linear":
        kind = ImageRidge.kind if "side" in arrays else MarkerRidge.kind
    return ESTIMATORS.get(kind)(name, arrays)
