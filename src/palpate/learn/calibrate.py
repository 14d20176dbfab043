"""Calibration of conformal intervals by held-out presses, and their coverage on further presses."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray, child_seed, generator
from palpate.datasets import Dataset, draw_jitter, split_presses
from palpate.learn.components import principal_directions
from palpate.learn.estimator import Estimator
from palpate.learn.interval import Interval, TrainedRange, press_quantile

LEVEL = 0.9
"""Share of true values that an interval covers."""
FALSE_ALARM = 0.02
"""Share of images inside the trained range that may be flagged; more where few presses calibrate.
By hand."""
SHARE = 0.5
"""Share of the held-out presses that calibrate; coverage is measured on the remaining ones. By hand."""
DRAWS = 4
"""Draws of jitter for each held-out image, and at each pose of an error bound. By hand."""
MOST_IMAGES = 4096
"""Training images on which the error of each depth is measured. By hand."""
LEAST_NOISE_PX = 0.05
"""Noise of a marker's position for a dataset without jitter: that of the detector (px)."""
LEAST_ERROR = 1e-6
"""Minimum RMS error of a depth, in its unit: avoids a division by zero."""


@dataclass(frozen=True)
class Coverage:
    """Coverage of intervals, on jittered images of presses that neither trained nor calibrated.

    Attributes
    ----------
    level
        Nominal coverage.
    presses, images
        Numbers of presses and of jittered images.
    angle, depth
        Share of true values inside the interval: rx and ry pooled, and depth.
    half_width_deg, half_width_mm
        Mean half-width, of rx and ry pooled, and of depth.
    flagged_ood
        Share of images flagged as out of distribution, all of them falsely.
    false_alarm
        Upper limit of this share.
    """

    level: float
    presses: int
    images: int
    angle: float
    depth: float
    half_width_deg: float
    half_width_mm: float
    flagged_ood: float
    false_alarm: float


def calibrate_interval(estimator: Estimator, dataset: Dataset, seed: int = 0) -> Estimator:
    """Calibrate the interval of an estimator by some of the held-out presses; estimates do not change.

    Parameters
    ----------
    estimator
        Trained on the presses of `dataset` that are not held out.
    dataset
        Its images, poses and split.
    seed
        Seed of the choice of presses and of the jitter.

    Returns
    -------
    Estimator
        With an interval; unchanged if a single press is held out, since none would remain for the coverage.
    """
    kept, held = dataset.subset(validation=False), dataset.subset(validation=True)
    if len(np.unique(held.press)) < 2:
        return estimator
    chosen = split_presses(held.press, child_seed(seed, "calibration"), SHARE).validation
    depths, error = _measure_scale(estimator, kept, seed)
    images, poses, press = draw_images(held, held.poses, chosen, child_seed(seed, "calibration jitter"))
    members = estimator.predict_members(images)
    trained = _find_range(kept, seed)
    presses = tuple(int(number) for number in np.unique(press))
    plain = Interval(LEVEL, np.ones(3), depths, error, trained, presses)
    scores = np.abs(members.mean(axis=0) - poses) / plain.scale(members)
    factor = press_quantile(scores, press, LEVEL)
    false_alarm = max(FALSE_ALARM, 1.0 / (len(presses) + 1))
    beside = plain.score((images - dataset.rest_px).reshape(len(images), -1), members)
    threshold = float(press_quantile(beside, press, 1.0 - false_alarm))
    trained = replace(trained, threshold=threshold, false_alarm=false_alarm)
    return replace(estimator, interval=replace(plain, factor=factor, trained=trained))


def measure_coverage(estimator: Estimator, dataset: Dataset, seed: int = 0) -> Coverage | None:
    """Measure the coverage of intervals on the held-out presses that did not calibrate them.

    Parameters
    ----------
    estimator
        The calibrated estimator.
    dataset
        The dataset that it was calibrated on.
    seed
        Seed of the jitter.

    Returns
    -------
    Coverage | None
        `None` if the estimator has no interval, or an infinite one.
    """
    interval = estimator.interval
    held = dataset.subset(validation=True)
    if interval is None or not np.isfinite(interval.factor).all():
        return None
    rows = ~np.isin(held.press, interval.presses)
    images, poses, press = draw_images(held, held.poses, rows, child_seed(seed, "coverage"))
    found = estimator.estimate(images)
    covered = np.abs(found.pose - poses) <= found.half_width
    return Coverage(
        level=interval.level,
        presses=len(np.unique(press)),
        images=len(images),
        angle=float(covered[:, :2].mean()),
        depth=float(covered[:, 2].mean()),
        half_width_deg=float(found.half_width[:, :2].mean()),
        half_width_mm=float(found.half_width[:, 2].mean()),
        flagged_ood=float(found.out_of_distribution.mean()),
        false_alarm=interval.trained.false_alarm,
    )


def draw_images(
    held: Dataset, targets: FloatArray, rows: BoolArray, seed: int
) -> tuple[FloatArray, FloatArray, IntArray]:
    """Draw images, targets (n, k) and presses of some rows, with `DRAWS` draws of jitter each."""
    images = draw_jitter(np.tile(held.images_px[rows], (DRAWS, 1, 1)), held.spec.jitter_px, generator(seed))
    return images, np.tile(targets[rows], (DRAWS, 1)), np.tile(held.press[rows], DRAWS)


def _measure_scale(estimator: Estimator, model: Dataset, seed: int) -> tuple[FloatArray, FloatArray]:
    """Measure depths (d,) and RMS error (d, 3) on training images with new jitter."""
    rng = generator(seed, "scale")
    rows = rng.permutation(len(model.poses))[:MOST_IMAGES]
    images = draw_jitter(model.images_px[rows], model.spec.jitter_px, rng)
    squares = (estimator.predict(images) - model.poses[rows]) ** 2
    depth = np.round(model.poses[rows, 2], 6)
    depths = np.unique(depth)
    error = np.sqrt([squares[depth == one].mean(axis=0) for one in depths])
    return depths, np.maximum(error, LEAST_ERROR)


def _find_range(model: Dataset, seed: int) -> TrainedRange:
    """Find the trained range, without a threshold yet."""
    noise = max(model.spec.jitter_px / np.sqrt(3.0), LEAST_NOISE_PX)
    moved = (model.images_px - model.rest_px).reshape(len(model.images_px), -1)
    centre = moved.mean(axis=0)
    variance, directions = principal_directions(np.cov(moved, rowvar=False))
    directions = directions[:, variance > min(noise**2, float(variance[0]) / 2)]
    coordinates = (moved - centre) @ directions
    rows = generator(seed, "range").permutation(len(moved))[:MOST_IMAGES]
    noisy = draw_jitter(moved[rows], model.spec.jitter_px, generator(seed, "range jitter")) - centre
    rest = np.sqrt(((noisy - noisy @ directions @ directions.T) ** 2).mean(axis=1))
    return TrainedRange(
        centre=centre,
        directions=directions,
        low=coordinates.min(axis=0),
        high=coordinates.max(axis=0),
        noise_px=float(noise),
        rest_mean_px=float(rest.mean()),
        rest_sd_px=max(float(rest.std()), LEAST_NOISE_PX / np.sqrt(moved.shape[1])),
        tilt_deg=float(np.hypot(model.poses[:, 0], model.poses[:, 1]).max()),
        min_depth_mm=float(model.poses[:, 2].min()),
        max_depth_mm=float(model.poses[:, 2].max()),
        threshold=float("inf"),
        false_alarm=0.0,
    )
