"""Errors of an estimator, by the figures of the paper: RMSE, MAE, Max.Abs.Error, SD.

The paper evaluates a design by its angles alone. With the errors e of n images in both components (rx, ry)

    RMSE = sqrt( Σ (e_rx² + e_ry²) / 2n )        max = max( |e_rx|, |e_ry| )

so both components are pooled, and the maximum is that of a single component, not of the angle between the normals.
Depth, or the place (x, y) of an obstacle, is reported separately.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.design import TILT_SPACE, PoseSpace

TILT_STEP_DEG = 2.0
"""Width of the intervals of tilt, as the paper's step."""
ROUNDING = 1e-9
"""A tilt closer than this to the end of an interval (in intervals) counts as at the end."""


@dataclass(frozen=True)
class ErrorSummary:
    """Five figures of a set of errors e, in the unit of e.

    Attributes
    ----------
    rmse, mae, max
        Root mean square, mean and maximum absolute error.
    sd, bias
        Standard deviation about the mean error (divisor n) and the mean error: rmse² = sd² + bias².
    """

    rmse: float
    mae: float
    max: float
    sd: float
    bias: float

    @classmethod
    def of(cls, errors: FloatArray) -> Self:
        """Summarise errors of any shape, at least one."""
        if errors.size == 0:
            raise PalpateError(
                "There is no image to measure an error on.",
                "Hold out at least one press.",
                code="evaluation-no-image",
            )
        size = np.abs(errors)
        return cls(
            rmse=float(np.sqrt(np.mean(errors**2))),
            mae=float(np.mean(size)),
            max=float(np.max(size)),
            sd=float(np.std(errors)),
            bias=float(np.mean(errors)),
        )


@dataclass(frozen=True)
class DepthErrors:
    """Errors of the images at one depth.

    Attributes
    ----------
    depth_mm
        Depth of the obstacle (mm).
    images
        Number of images.
    by_axis
        See `Metrics`.
    """

    depth_mm: float
    images: int
    by_axis: Mapping[str, ErrorSummary]

    @property
    def pooled(self) -> ErrorSummary:
        """Errors of the first two components, pooled."""
        return next(iter(self.by_axis.values()))


@dataclass(frozen=True)
class TiltErrors:
    """Errors of the images whose wall has a tilt in one interval.

    Attributes
    ----------
    from_deg, to_deg
        The interval of true tilts (degrees), its lower end included; the last one includes both.
    images
        Number of images.
    angle
        Errors of rx and ry pooled (degrees).
    """

    from_deg: float
    to_deg: float
    images: int
    angle: ErrorSummary

    @property
    def pooled(self) -> ErrorSummary:
        """See `Metrics.pooled`."""
        return self.angle


@dataclass(frozen=True)
class Metrics:
    """Errors on a set of images.

    Attributes
    ----------
    images
        Number of images.
    by_axis
        By the names of `PoseSpace.errors`: ``angle`` pools rx and ry, the paper's RMSE and Max.Abs.Error, then ``rx``
        and ``ry`` (degrees) and ``depth`` (mm).
    by_depth
        The same for the images of each depth, by ascending depth.
    by_tilt
        Errors of the angle in intervals of `TILT_STEP_DEG`, by ascending tilt; intervals without images are left out.
        Empty if the obstacle does not tilt.
    """

    images: int
    by_axis: Mapping[str, ErrorSummary]
    by_depth: tuple[DepthErrors, ...]
    by_tilt: tuple[TiltErrors, ...]

    @property
    def pooled(self) -> ErrorSummary:
        """Errors of the first two components, pooled: the angle (degrees), or the offset (mm)."""
        return next(iter(self.by_axis.values()))

    @property
    def rmse_deg(self) -> float:
        """The paper's RMSE, over both components of the angle (degrees)."""
        return self.pooled.rmse

    @property
    def max_error_deg(self) -> float:
        """The paper's Max.Abs.Error, of a single component of the angle (degrees)."""
        return self.pooled.max

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON data; `from_dict` reads it back."""
        by_depth = [
            {"depth_mm": part.depth_mm, "images": part.images, **_plain(part.by_axis)} for part in self.by_depth
        ]
        by_tilt = [asdict(part) for part in self.by_tilt]
        return {"images": self.images, **_plain(self.by_axis), "by_depth": by_depth, "by_tilt": by_tilt}

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Self:
        """Build errors from the data of `as_dict`."""
        by_depth = tuple(DepthErrors(item["depth_mm"], item["images"], _read(item)) for item in data["by_depth"])
        by_tilt = tuple(TiltErrors(**{**item, "angle": ErrorSummary(**item["angle"])}) for item in data["by_tilt"])
        return cls(data["images"], _read(data), by_depth, by_tilt)


def _plain(by_axis: Mapping[str, ErrorSummary]) -> dict[str, dict[str, float]]:
    return {name: asdict(summary) for name, summary in by_axis.items()}


def _read(data: Mapping[str, Any]) -> dict[str, ErrorSummary]:
    return {name: ErrorSummary(**value) for name, value in data.items() if isinstance(value, dict)}


def measure_errors(estimates: FloatArray, poses: FloatArray, space: PoseSpace = TILT_SPACE) -> Metrics:
    """Compare estimates with the ground truth.

    Parameters
    ----------
    estimates, poses
        (n, 3) each: rx and ry (degrees), depth (mm), or the components of `space`.
    space
        Meaning of the columns.

    Returns
    -------
    Metrics
        Errors over all images, by the true depth and by the true tilt.

    Raises
    ------
    PalpateError
        If there is no image, or an estimate is not a number.

    Examples
    --------
    >>> errors = measure_errors(np.array([[1.0, 0.0, 4.1]]), np.array([[0.0, 0.0, 4.0]]))
    >>> round(errors.rmse_deg, 4), errors.max_error_deg, round(errors.by_axis["depth"].rmse, 6)
    (0.7071, 1.0, 0.1)
    """
    if estimates.shape != poses.shape:
        raise PalpateError(
            f"{estimates.shape} estimates cannot be compared with {poses.shape} poses.", code="estimates-shape"
        )
    errors = np.asarray(estimates, dtype=float) - poses
    if not np.isfinite(errors).all():
        count = int((~np.isfinite(errors).all(axis=1)).sum())
        raise PalpateError(
            f"{count} of {len(errors)} estimates are not numbers.",
            "Lower the learning rate and train again.",
            code="estimates-not-finite",
        )
    depths = np.round(poses[:, 2], 6)
    by_depth = tuple(
        DepthErrors(float(depth), int((depths == depth).sum()), _by_axis(errors[depths == depth], space))
        for depth in np.unique(depths)
    )
    every = _by_axis(errors, space)
    by_tilt = tuple(_by_tilt(errors, np.hypot(poses[:, 0], poses[:, 1]))) if space.is_tilt else ()
    return Metrics(len(errors), every, by_depth, by_tilt)


def _by_tilt(errors: FloatArray, tilt_deg: FloatArray) -> Iterator[TiltErrors]:
    last = max(int(np.ceil(tilt_deg.max() / TILT_STEP_DEG - ROUNDING)), 1) - 1
    interval = np.minimum(np.floor(tilt_deg / TILT_STEP_DEG + ROUNDING), last)
    for number in np.unique(interval):
        angle = errors[interval == number, :2]
        ends = (float(number * TILT_STEP_DEG), float((number + 1) * TILT_STEP_DEG))
        yield TiltErrors(*ends, images=len(angle), angle=ErrorSummary.of(angle))


def _by_axis(errors: FloatArray, space: PoseSpace) -> dict[str, ErrorSummary]:
    return {
        name: ErrorSummary.of(errors[:, columns] if len(columns) > 1 else errors[:, columns[0]])
        for name, columns, _ in space.errors
    }
