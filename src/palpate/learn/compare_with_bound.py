"""Comparison of an estimator's errors with the error bound; errors far below it show leakage."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from palpate.datasets import DatasetSpec
from palpate.learn.error_bound import ErrorBound
from palpate.learn.metrics import Metrics

STANDARD_ERRORS = 3.0
"""Number of standard errors below the floor from which a jittered RMSE counts as leakage. By hand."""


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
        `None` if no depth has both a bound and images.
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
    """Pool the bound over an estimator's images, and divide its jittered RMSE by the least-squares bound.

    Parameters
    ----------
    jittered
        Errors on jittered images.
    limits
        Bounds of the same design.

    Returns
    -------
    tuple[PooledBound, float] | None
        Both over the depths that have a bound; `None` without such depths or without jitter.
    """
    bounded = {_depth(limit.depth_mm) for limit in limits}
    judged = [errors for errors in jittered.by_depth if _depth(errors.depth_mm) in bounded]
    pooled = pool_bounds(limits, {_depth(errors.depth_mm): errors.images for errors in judged})
    if pooled is None or pooled.least_squares_deg == 0:
        return None
    square = sum(errors.images * errors.pooled.rmse**2 for errors in judged) / sum(errors.images for errors in judged)
    return pooled, math.sqrt(square) / pooled.least_squares_deg


def find_leakage(jittered: Metrics, limits: Sequence[ErrorBound], spec: DatasetSpec) -> str:
    """Report the depth at which errors are below the floor, which shows leakage; else return ''.

    The floor holds if poses fill the disc of tilts evenly. The few repeated poses of the paper give an estimator more
    information, so they are not tested. The RMSE of n images has a standard error of RMSE / 2√n.

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
