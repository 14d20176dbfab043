"""A calibration: the lens of a camera, how sure it is, and what it was made from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.camera.board import BoardSpec
from palpate.camera.spec import CameraSpec
from palpate.core import PalpateError

Array = NDArray[np.float64]
PINHOLE, FISHEYE = "plumb_bob", "equidistant"
"""Names of the lens models, as in ROS: Brown's polynomial, and OpenCV's fisheye."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """What was found about a camera.

    Attributes
    ----------
    model
        ``"plumb_bob"`` (k1, k2, p1, p2, k3) or ``"equidistant"`` (k1, k2, k3, k4).
    width_px, height_px
        Size of the images.
    intrinsics_px
        (4,) fx, fy, cx, cy.
    distortion
        (5,) or (4,) coefficients of the model.
    rms_px
        Root of the mean over all points of the squared distance between seen and projected point.
    covariance
        (k, k) of intrinsics and distortion, from the residuals; NaN where the model gives none.
    image_names, image_rms_px
        Used images and the same root for each.
    rejected
        Images that were not used, with the reason.
    coverage
        (6, 8) number of points in each cell of the image, from its top left corner.
    board
        The board, `None` where it is not known.
    """

    model: str
    width_px: int
    height_px: int
    intrinsics_px: Array
    distortion: Array
    rms_px: float
    covariance: Array
    image_names: tuple[str, ...]
    image_rms_px: Array
    rejected: tuple[tuple[str, str], ...]
    coverage: NDArray[np.intp]
    board: BoardSpec | None

    @property
    def sd(self) -> Array:
        """(k,) standard deviation of intrinsics and distortion."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def covered(self) -> float:
        """Share of the cells of the image that hold a point."""
        return float((self.coverage > 0).mean())

    def camera_spec(self, nominal: CameraSpec | None = None) -> CameraSpec:
        """The nominal camera's pose with this lens.

        Raises
        ------
        PalpateError
            If the lens is a fisheye: the chain projects by Brown's polynomial, whose coefficients mean another thing.
        """
        if self.model != PINHOLE:
            raise PalpateError(
                "A fisheye calibration cannot be used as a pinhole with Brown's distortion.",
                "Calibrate again without fisheye.",
            )
        fx, fy, cx, cy = (float(value) for value in self.intrinsics_px)
        lens = {
            "width_px": self.width_px,
            "height_px": self.height_px,
            "fx_px": fx,
            "fy_px": fy,
            "cx_px": cx,
            "cy_px": cy,
            "distortion": tuple(float(value) for value in self.distortion),
        }
        return CameraSpec(**{**(nominal or CameraSpec()).model_dump(), **lens})
