"""Errors of an estimator against the truth, in the words of the paper: RMSE, MAE, Max.Abs.Error, SD.

The paper judges a design by its angles alone. With the errors e of n images in both components (rx, ry)

    RMSE = sqrt( Σ (e_rx² + e_ry²) / 2n )        max = max( |e_rx|, |e_ry| )

so one number pools both components, and the maximum is that of a single component, not of the angle between
the two normals. Depth is estimated as well and reported by itself.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from palpate.core import PalpateError

Array = NDArray[np.float64]


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
    def of(cls, errors: Array) -> Self:
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
    """

    images: int
    angle: ErrorSummary
    rx: ErrorSummary
    ry: ErrorSummary
    depth: ErrorSummary
    by_depth: tuple[DepthErrors, ...]

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
        return cls(images=data["images"], by_depth=by_depth, **summaries)


_AXES = ("angle", "rx", "ry", "depth")


def measure_errors(estimates: Array, poses: Array) -> Metrics:
    """Compare estimates with the truth.

    Parameters
    ----------
    estimates, poses
        (n, 3) each: rx and ry (degrees), depth (mm).

    Returns
    -------
    Metrics
        Errors over all images, and by the true depth.

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
    return Metrics(images=len(errors), by_depth=by_depth, **_by_axis(errors))


def _by_axis(errors: Array) -> dict[str, ErrorSummary]:
    parts = (errors[:, :2], errors[:, 0], errors[:, 1], errors[:, 2])
    return {name: ErrorSummary.of(part) for name, part in zip(_AXES, parts, strict=True)}
