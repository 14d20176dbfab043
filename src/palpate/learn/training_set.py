"""Samples of one training: inputs, targets, and the images for training and for validation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import BoolArray, FloatArray, IntArray, load_opencv
from palpate.learn.rotation import RotationAugmentation


@dataclass(frozen=True, eq=False)
class TrainingSet:
    """Samples of one training.

    Attributes
    ----------
    inputs
        (n, m, 2) displacements or (n, h, w) images.
    targets
        (n, k) poses; auxiliary targets come last.
    train, validation
        (n,) samples for the weights, and for choices.
    seed
        Seed of weights and batches.
    rotation
        How rotated images train as well; `None` if they do not.
    auxiliary
        Number of targets that help the training and are not estimated.
    press
        (n,) number of each image's press; `None` if every image is one.
    """

    inputs: NDArray[Any]
    targets: FloatArray
    train: BoolArray
    validation: BoolArray
    seed: int = 0
    rotation: RotationAugmentation | None = None
    auxiliary: int = 0
    press: IntArray | None = None

    @property
    def press_numbers(self) -> IntArray:
        """(n,) number of each image's press."""
        return np.arange(len(self.targets)) if self.press is None else self.press

    @property
    def chosen_by(self) -> BoolArray:
        """(n,) validation samples, or the training samples without them."""
        return self.validation if self.validation.any() else self.train

    @property
    def n_outputs(self) -> int:
        """Number of targets that are estimated."""
        return self.targets.shape[1] - self.auxiliary

    @property
    def scale(self) -> tuple[FloatArray, FloatArray]:
        """Mean and standard deviation (k,) of the training targets; 0 and RMS if symmetry negates them."""
        mean, sd = self.targets[self.train].mean(axis=0), self.targets[self.train].std(axis=0)
        if self.rotation is not None:
            mean[:2], sd[:2] = 0.0, sd[:2].mean()
            if self.rotation.frame_rad is not None and self.rotation.odd:
                odd = list(self.rotation.odd)
                mean[odd], sd[odd] = 0.0, np.hypot(mean[odd], sd[odd])
        return mean, np.where(sd > 1e-9, sd, 1.0)

    @property
    def standardised(self) -> FloatArray:
        """(n, k) targets less their mean, over their standard deviation."""
        mean, sd = self.scale
        return np.asarray((self.targets - mean) / sd)

    def error(self, estimates: FloatArray) -> float:
        """Root mean square error of the samples `chosen_by`, over the standard deviations of the targets."""
        return float(np.sqrt(np.mean(((estimates - self.targets[self.chosen_by]) / self.scale[1]) ** 2)))


def flat_features(inputs: NDArray[Any], side: int | None) -> NDArray[np.float32]:
    """Rows (n, p): displacements, or images shrunk so that the longer side has `side` px."""
    if side is None:
        return np.asarray(inputs, np.float32).reshape(len(inputs), -1)
    cv2 = load_opencv()
    height, width = (max(1, round(length * side / max(inputs.shape[1:]))) for length in inputs.shape[1:])
    small = [cv2.resize(one, (width, height), interpolation=cv2.INTER_AREA) for one in inputs]
    return np.asarray(small, np.float32).reshape(len(inputs), -1) / np.float32(255)
