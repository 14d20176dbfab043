"""Conformal intervals of estimates, and flags of images that are out of distribution.

The half-width of the interval of one component of the pose is

    h(x) = q · sqrt( spread(x)² + s(depth)² )

with the spread of the ensemble's members, the error s that jitter alone causes at that depth (RMS over training
images, linear between their depths), and one factor q a component. The factor is the quantile of |error| / sqrt(…)
over presses that trained nothing. Images of one press are nearly identical, so presses, not images, are exchangeable:
each of K presses has the weight 1 / (K + 1), shared by its images, and the remaining weight belongs to the next press
(Lee, Barber & Willett 2023, "Distribution-free inference with hierarchical data"). The interval then covers at least
the level on average over new presses, for any estimator.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray
from palpate.design import PoseEstimate


@dataclass(frozen=True, eq=False)
class Prediction(PoseEstimate):
    """Estimates (n, k) of n images by a trained model, with flags and forces.

    Attributes
    ----------
    out_of_distribution
        (n,) whether the marker motion is unlike all training images; estimate and interval are then invalid.
    forces, forces_half_width
        (n, 3) N by `palpate.learn.FORCE_AXES`; `None` if the model has no forces.
    """

    out_of_distribution: BoolArray
    forces: FloatArray | None = None
    forces_half_width: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class TrainedRange:
    """Range of the training displacements.

    Displacements of clean images span a few principal directions, each with a minimum and a maximum training
    coordinate. The score of an image is the maximum of: excess over these coordinates, in standard deviations of the
    jitter; residual outside the directions, in standard deviations over the training; estimated tilt and depth beyond
    the trained ones, in expected errors.

    Attributes
    ----------
    centre, directions
        (2m,) px and (2m, k): coordinates are (displacement − centre) · directions.
    low, high
        (k,) px, of the clean training images.
    noise_px
        Standard deviation of one coordinate under jitter (px).
    rest_mean_px, rest_sd_px
        Mean and standard deviation, over jittered training images, of the RMS residual (px).
    tilt_deg
        Maximum tilt (degrees).
    min_depth_mm, max_depth_mm
        Depths (mm).
    threshold
        Maximum score inside the range.
    false_alarm
        Share of images of new presses, at most, that are flagged as out of distribution.
    """

    centre: FloatArray
    directions: FloatArray
    low: FloatArray
    high: FloatArray
    noise_px: float
    rest_mean_px: float
    rest_sd_px: float
    tilt_deg: float
    min_depth_mm: float
    max_depth_mm: float
    threshold: float
    false_alarm: float

    def score(self, displacement_px: FloatArray, poses: FloatArray, scale: FloatArray) -> FloatArray:
        """Score (n,) from displacements (n, 2m) from rest (px), poses (n, 3) and their expected errors (n, 3)."""
        moved = displacement_px - self.centre
        coordinates = moved @ self.directions
        excess = np.maximum(self.low - coordinates, coordinates - self.high).max(axis=1) / self.noise_px
        rest = np.sqrt(((moved - coordinates @ self.directions.T) ** 2).mean(axis=1))
        tilt_scale = np.sqrt((scale[:, :2] ** 2).mean(axis=1))
        parts = (
            excess,
            (rest - self.rest_mean_px) / self.rest_sd_px,
            (np.hypot(poses[:, 0], poses[:, 1]) - self.tilt_deg) / tilt_scale,
            (self.min_depth_mm - poses[:, 2]) / scale[:, 2],
            (poses[:, 2] - self.max_depth_mm) / scale[:, 2],
        )
        score: FloatArray = np.max(parts, axis=0)
        return score


@dataclass(frozen=True, eq=False)
class Interval:
    """Calibrated half-widths and the trained range of one estimator.

    Attributes
    ----------
    level
        Share of the true values that the interval covers, on average over new presses, e.g. 0.9.
    factor
        (3,) q of each component; infinite if there were too few presses for the level.
    depths_mm, error
        (d,) ascending depths and (d, 3) RMS error on jittered training images there (degrees, degrees, mm).
    trained
        The trained range.
    presses
        Numbers of the dataset's presses that calibrated it.
    """

    level: float
    factor: FloatArray
    depths_mm: FloatArray
    error: FloatArray
    trained: TrainedRange
    presses: tuple[int, ...]

    def scale(self, member_poses: FloatArray) -> FloatArray:
        """Expected error (n, 3) before calibration, from the members' poses (r, n, 3)."""
        depth = member_poses.mean(axis=0)[:, 2]
        error = np.stack([np.interp(depth, self.depths_mm, column) for column in self.error.T], axis=1)
        scale: FloatArray = np.sqrt(member_poses.var(axis=0) + error**2)
        return scale

    def half_width(self, member_poses: FloatArray) -> FloatArray:
        """Half-widths (n, 3) in degrees, degrees, mm, from the members' poses (r, n, 3)."""
        return self.factor * self.scale(member_poses)

    def score(self, displacement_px: FloatArray, member_poses: FloatArray) -> FloatArray:
        """Out-of-distribution score (n,), from displacements (n, 2m) in px and poses (r, n, 3)."""
        return self.trained.score(displacement_px, member_poses.mean(axis=0), self.scale(member_poses))

    def is_out_of_distribution(self, displacement_px: FloatArray, member_poses: FloatArray) -> BoolArray:
        """Whether images are out of the trained range; for parameters see `score`."""
        flags: BoolArray = self.score(displacement_px, member_poses) > self.trained.threshold
        return flags


def press_quantile(scores: FloatArray, press: IntArray, level: float) -> FloatArray:
    """Smallest numbers that at least a share of the scores of a new press stay below.

    Parameters
    ----------
    scores
        (n, …) scores of each image.
    press
        (n,) number of the press of each image.
    level
        The share, on average over the choice of presses.

    Returns
    -------
    FloatArray
        (…) of each column; infinite if K presses are too few: K + 1 < 1 / (1 − level).
    """
    _, member, images = np.unique(press, return_inverse=True, return_counts=True)
    weight = 1.0 / ((len(images) + 1) * images[member.reshape(-1)])
    order = np.argsort(scores, axis=0)
    below = np.asarray((np.cumsum(weight[order], axis=0) < level - 1e-12).sum(axis=0))
    ascending = np.concatenate([np.take_along_axis(scores, order, axis=0), np.full((1, *scores.shape[1:]), np.inf)])
    return np.asarray(np.take_along_axis(ascending, below[None], axis=0)[0])
