"""Estimator: a trained map from marker positions to the pose of the obstacle."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from palpate.core import FloatArray, PalpateError, stage_version
from palpate.datasets import Normalisation
from palpate.design import TILT_SPACE, PoseSpace
from palpate.learn.interval import Interval, Prediction
from palpate.learn.perceptron import evaluate_perceptrons


@dataclass(frozen=True, eq=False)
class Estimator:
    """One or more perceptrons as plain arrays; prediction needs numpy only.

    Attributes
    ----------
    normalisation
        Map from pixels to the input of the first layer.
    weights, biases
        One (r, in, out) and one (r, out) a layer, for r members; the last layer gives standardised poses.
    activation
        ``"relu"`` or ``"silu"``, after each layer but the last.
    output_mean, output_sd
        (3,) of the components of `space`, in their units.
    rest_px
        (m, 2) markers of the undeformed dome (px): the order in which the markers must come.
    seed
        Seed of the training.
    made_by
        Method and spec of the training, as JSON data.
    training_images, validation_images
        Numbers of training and validation images.
    history
        For each member, the validation error (standardised) after each epoch; empty for a closed form.
    repeat_rmse_deg
        RMSE of the angle of every repeat on clean held-out images (degrees), also of discarded repeats; empty for a
        closed form.
    interval
        Half-widths and trained range (`calibrate`); `None` if not calibrated.
    version
        Version of the training stage.
    space
        Components of the estimated pose.
    """

    normalisation: Normalisation
    weights: tuple[FloatArray, ...]
    biases: tuple[FloatArray, ...]
    activation: str
    output_mean: FloatArray
    output_sd: FloatArray
    rest_px: FloatArray
    seed: int
    made_by: Mapping[str, Any]
    training_images: int
    validation_images: int
    history: tuple[tuple[float, ...], ...] = ()
    repeat_rmse_deg: tuple[float, ...] = ()
    interval: Interval | None = None
    version: str = field(default_factory=lambda: stage_version("estimator"))
    space: PoseSpace = TILT_SPACE

    @property
    def members(self) -> int:
        """Number of networks that are averaged."""
        return len(self.weights[0])

    def predict(self, images_px: FloatArray) -> FloatArray:
        """Estimate poses.

        Parameters
        ----------
        images_px
            (n, m, 2) u and v of every marker, in the order of `rest_px`.

        Returns
        -------
        FloatArray
            (n, 3) by `space`: rx and ry (degrees), depth (mm); the mean over the members.

        Raises
        ------
        PalpateError
            If the images have another number of markers.
        """
        mean: FloatArray = self.predict_members(images_px).mean(axis=0)
        return mean

    def estimate(self, images_px: FloatArray) -> Prediction:
        """Estimate poses of images (n, m, 2) (see `predict`), with half-widths and out-of-distribution flags.

        Without an interval the half-widths are infinite and no image is out of distribution.
        """
        members = self.predict_members(images_px)
        poses = members.mean(axis=0)
        if self.interval is None:
            half, outside = np.full(poses.shape, np.inf), np.zeros(len(poses), dtype=bool)
        else:
            moved = (images_px - self.rest_px).reshape(len(images_px), -1)
            half = self.interval.half_width(members)
            outside = self.interval.is_out_of_distribution(moved, members)
        return Prediction(poses, half, outside, space=self.space)

    def predict_members(self, images_px: FloatArray) -> FloatArray:
        """Estimate poses (r, n, 3) by every member for images (n, m, 2), see `predict`."""
        if images_px.shape[1:] != self.rest_px.shape:
            raise PalpateError(
                f"The images have markers of shape {images_px.shape[1:]}, the estimator reads {self.rest_px.shape}.",
                "Use the estimator of this marker layout.",
                code="model-marker-count",
            )
        inputs = self.normalisation.apply(images_px).reshape(len(images_px), -1)
        outputs = evaluate_perceptrons(inputs, self.weights, self.biases, self.activation)
        return np.asarray(outputs * self.output_sd + self.output_mean)

    def keep_members(self, rows: list[int]) -> Estimator:
        """Return the estimator with some of its members only, and without the interval."""
        return replace(
            self,
            weights=tuple(weight[rows] for weight in self.weights),
            biases=tuple(bias[rows] for bias in self.biases),
            history=tuple(self.history[row] for row in rows),
            interval=None,
        )
