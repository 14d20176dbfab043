"""Errors of an estimator against the truth, in the words of the paper: RMSE, MAE, Max.Abs.Error, SD.

The paper judges a design by its angles alone. With the errors e of n images in both components (rx, ry)

    RMSE = sqrt( Σ (e_rx² + e_ry²) / 2n )        max = max( |e_rx|, |e_ry| )

so one number pools both components, and the maximum is that of a single component, not of the angle between
the two normals. Depth is estimated as well and reported by itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.design import TILT_DEPTH

TILT_STEP_DEG = 2.0
"""Width of the intervals of tilt, as the paper's step."""
ROUNDING = 1e-9
"""A tilt so near to the end of an interval (in intervals) stands on it."""


@dataclass(frozen=True)
class ErrorSummary:
    """Five figures of a set of errors e, in the unit of e.

    Attributes
    ----------
    rmse, mae, max
        Root mean square, mean and greatest absolute error.
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
            raise PalpateError("There is no image to measure an error on.", "Hold out at least one press.")
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
        Depth of the wall (mm).
    images
        Number of images.
    angle, rx, ry
        Errors of both components pooled, and of each (degrees).
    depth
        Errors of the estimated depth (mm).
    """

    depth_mm: float
    images: int
    angle: ErrorSummary
    rx: ErrorSummary
    ry: ErrorSummary
    depth: ErrorSummary


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
        Errors of both components pooled (degrees).
    """

    from_deg: float
    to_deg: float
    images: int
    angle: ErrorSummary


@dataclass(frozen=True)
class Metrics:
    """Errors on a set of images.

    Attributes
    ----------
    images
        Number of images.
    angle
        Errors of rx and ry pooled: the paper's RMSE and Max.Abs.Error (degrees).
    rx, ry
        Errors of each component (degrees).
    depth
        Errors of the estimated depth (mm).
    by_depth
        The same for the images of each depth, by rising depth.
    by_tilt
        The angle's errors in intervals of `TILT_STEP_DEG`, by rising tilt; an interval without images is left out.
    """

    images: int
    angle: ErrorSummary
    rx: ErrorSummary
    ry: ErrorSummary
    depth: ErrorSummary
    by_depth: tuple[DepthErrors, ...]
    by_tilt: tuple[TiltErrors, ...]

    @property
    def rmse_deg(self) -> float:
        """The paper's RMSE, over both components of the angle (degrees)."""
        return self.angle.rmse

    @property
    def max_error_deg(self) -> float:
        """The paper's Max.Abs.Error, of a single component of the angle (degrees)."""
        return self.angle.max

    def as_dict(self) -> dict[str, Any]:
        """Plain JSON data; `from_dict` reads it back."""
        return asdict(self)

    @classmethod
    def from_dict(cls, data: dict[str, Any]) -> Self:
        """Read what `as_dict` wrote."""
        summaries = {name: ErrorSummary(**data[name]) for name in _AXES}
        by_depth = tuple(
            DepthErrors(
                depth_mm=item["depth_mm"],
                images=item["images"],
                **{name: ErrorSummary(**item[name]) for name in _AXES},
            )
            for item in data["by_depth"]
        )
        by_tilt = tuple(TiltErrors(**{**item, "angle": ErrorSummary(**item["angle"])}) for item in data["by_tilt"])
        return cls(images=data["images"], by_depth=by_depth, by_tilt=by_tilt, **summaries)


_AXES = tuple(name for name, _, _ in TILT_DEPTH.errors)


def measure_errors(estimates: FloatArray, poses: FloatArray) -> Metrics:
    """Compare estimates with the truth.

    Parameters
    ----------
    estimates, poses
        (n, 3) each: rx and ry (degrees), depth (mm).

    Returns
    -------
    Metrics
        Errors over all images, by the true depth and by the true tilt.

    Raises
    ------
    PalpateError
        If there is no image, or an estimate is not a number.
    """
    if estimates.shape != poses.shape:
        raise PalpateError(f"{estimates.shape} estimates cannot be compared with {poses.shape} poses.")
    errors = np.asarray(estimates, dtype=float) - poses
    if not np.isfinite(errors).all():
        count = int((~np.isfinite(errors).all(axis=1)).sum())
        raise PalpateError(
            f"{count} of {len(errors)} estimates are not numbers.", "Lower the learning rate and train again."
        )
    depths = np.round(poses[:, 2], 6)
    by_depth = tuple(
        DepthErrors(depth_mm=float(depth), images=int((depths == depth).sum()), **_by_axis(errors[depths == depth]))
        for depth in np.unique(depths)
    )
    every = _by_axis(errors)
    by_tilt = tuple(_by_tilt(errors, np.hypot(poses[:, 0], poses[:, 1])))
    return Metrics(images=len(errors), by_depth=by_depth, by_tilt=by_tilt, **every)


def _by_tilt(errors: FloatArray, tilt_deg: FloatArray) -> Iterator[TiltErrors]:
    last = max(int(np.ceil(tilt_deg.max() / TILT_STEP_DEG - ROUNDING)), 1) - 1
    interval = np.minimum(np.floor(tilt_deg / TILT_STEP_DEG + ROUNDING), last)
    for number in np.unique(interval):
        angle = errors[interval == number, :2]
        ends = (float(number * TILT_STEP_DEG), float((number + 1) * TILT_STEP_DEG))
        yield TiltErrors(*ends, images=len(angle), angle=ErrorSummary.of(angle))


def _by_axis(errors: FloatArray) -> dict[str, ErrorSummary]:
    return {
        name: ErrorSummary.of(errors[:, columns] if len(columns) > 1 else errors[:, columns[0]])
        for name, columns, _ in TILT_DEPTH.errors
    }
