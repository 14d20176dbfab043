"""An estimator's errors held against the limit: how near they come, and whether they come too near."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from palpate.datasets import DatasetSpec
from palpate.learn.error_bound import ErrorBound
from palpate.learn.metrics import Metrics

STANDARD_ERRORS = 3.0
"""A jittered RMSE so many standard errors below the floor is leakage."""


@dataclass(frozen=True)
class PooledBound:
    """Bounds over several depths, as root mean squares over their images (degrees).

    Attributes
    ----------
    least_squares_deg, pitman_deg
        See `ErrorBound`.
    """

    least_squares_deg: float
    pitman_deg: float


def pool_bounds(limits: Sequence[ErrorBound], images: Mapping[float, int] | None = None) -> PooledBound | None:
    """Pool the bounds of several depths as an RMSE over all images pools its depths.

    Parameters
    ----------
    limits
        Bounds by depth.
    images
        Number of images at each depth (mm); without it each depth counts by its share of the poses.

    Returns
    -------
    PooledBound | None
        `None` where no depth has both a bound and images.
    """
    weights = [limit.share if images is None else images.get(_depth(limit.depth_mm), 0) for limit in limits]
    total = sum(weights)
    if not total:
        return None
    pairs = list(zip(limits, weights, strict=True))
    return PooledBound(
        least_squares_deg=math.sqrt(sum(w * limit.least_squares_deg**2 for limit, w in pairs) / total),
        pitman_deg=math.sqrt(sum(w * limit.pitman_deg**2 for limit, w in pairs) / total),
    )


def compare_with_bound(jittered: Metrics, limits: Sequence[ErrorBound]) -> tuple[PooledBound, float] | None:
    """The pooled limit over the images of a judged estimator, and its jittered RMSE over the least-squares one.

    Parameters
    ----------
    jittered
        Errors on jittered images.
    limits
        Bounds of the same design.

    Returns
    -------
    tuple[PooledBound, float] | None
        Both over the depths that have a bound; `None` where there is none, or no jitter.
    """
    bounded = {_depth(limit.depth_mm) for limit in limits}
    judged = [errors for errors in jittered.by_depth if _depth(errors.depth_mm) in bounded]
    pooled = pool_bounds(limits, {_depth(errors.depth_mm): errors.images for errors in judged})
    if pooled is None or pooled.least_squares_deg == 0:
        return None
    square = sum(errors.images * errors.pooled.rmse**2 for errors in judged) / sum(errors.images for errors in judged)
    return pooled, math.sqrt(square) / pooled.least_squares_deg


def find_leakage(jittered: Metrics, limits: Sequence[ErrorBound], spec: DatasetSpec) -> str:
    """Say at which depth an estimator is better than any can be; empty where it is nowhere.

    The floor holds where poses fill the disc of tilts evenly; the paper's few repeated poses give an estimator more
    to know, so they are not judged. The RMSE of n images is itself uncertain by RMSE / 2√n.

    Parameters
    ----------
    jittered
        Errors on jittered images.
    limits
        Bounds of the same design.
    spec
        The dataset's.
    """
    if spec.poses != "disc":
        return ""
    measured = {_depth(errors.depth_mm): errors for errors in jittered.by_depth}
    for limit in limits:
        errors = measured.get(_depth(limit.depth_mm))
        if errors is None:
            continue
        rmse = errors.pooled.rmse
        uncertain = math.hypot(limit.floor_error_deg, rmse / (2 * math.sqrt(errors.images)))
        if rmse < limit.floor_deg - STANDARD_ERRORS * uncertain:
            return (
                f"Leakage: the jittered RMSE at {limit.depth_mm:g} mm is {rmse:.3g}°, but no estimator of one image "
                f"can be below {limit.floor_deg:.3g}° (± {uncertain:.2g}°) over these poses."
            )
    return ""


def _depth(depth_mm: float) -> float:
    return round(depth_mm, 6)
