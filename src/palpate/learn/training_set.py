"""What a part learns from; and ridge regression, the one that has a closed form."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import BoolArray, FloatArray
from palpate.learn.member import RidgeMember, flat_features
from palpate.learn.ridge import solve_ridge
from palpate.learn.rotation import RotationAugmentation

PENALTIES = tuple(10.0**k for k in range(-4, 4))
"""Ridge penalties that are tried, over the mean square of a feature and the number of images."""
SIDES = (16, 24, 32)
"""Sizes to which pictures are shrunk for ridge, px."""


@dataclass(frozen=True, eq=False)
class TrainingSet:
    """What a part learns from.

    Attributes
    ----------
    inputs
        (n, m, 2) displacements or (n, h, w) pictures.
    targets
        (n, k) poses; of networks that learn all motions, those asked for come first.
    train, validation
        (n,) images to learn from, and to choose by.
    seed
        Seed of weights and batches.
    rotation
        How turned images teach as well; `None` where they do not.
    """

    inputs: NDArray[Any]
    targets: FloatArray
    train: BoolArray
    validation: BoolArray
    seed: int = 0
    rotation: RotationAugmentation | None = None

    @property
    def scale(self) -> tuple[FloatArray, FloatArray]:
        """Mean and standard deviation (k,) of the targets that teach; of two that turn, none and one of both."""
        mean, sd = self.targets[self.train].mean(axis=0), self.targets[self.train].std(axis=0)
        if self.rotation is not None:
            mean[:2], sd[:2] = 0.0, sd[:2].mean()
        return mean, np.where(sd > 1e-9, sd, 1.0)

    def error(self, estimates: FloatArray) -> float:
        """Root mean square error of the images that judge, over the targets' standard deviations."""
        return float(np.sqrt(np.mean(((estimates - self.targets[self.validation]) / self.scale[1]) ** 2)))


def fit_ridge_part(name: str, lesson: TrainingSet, pictures: bool) -> RidgeMember:
    """Ridge regression with the penalty, and the size of pictures, that judge best."""
    best: dict[str, NDArray[Any]] = {}
    least = math.inf
    for side in SIDES if pictures else (None,):
        features = flat_features(lesson.inputs, side)
        taught = features[lesson.train]
        unit = max(float(taught.var(axis=0, dtype=float).mean()) * len(taught), 1e-12)
        for weight, bias in solve_ridge(taught, lesson.targets[lesson.train], [unit * one for one in PENALTIES]):
            error = lesson.error(features[lesson.validation] @ weight + bias)
            if error < least:
                least, best = error, {"weight": weight.astype(np.float32), "bias": bias}
                best |= {} if side is None else {"side": np.array(side)}
    return RidgeMember(name, best)
