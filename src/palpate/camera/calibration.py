"""A calibration: the lens of a camera, how sure it is, and what it was made from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.camera.board import BoardSpec
from palpate.camera.lens import Lens
from palpate.camera.spec import CameraSpec
from palpate.core import FloatArray


@dataclass(frozen=True, eq=False)
class Calibration:
    """What was found about a camera.

    Attributes
    ----------
    lens
        The lens.
    width_px, height_px
        Size of the images.
    intrinsics_px
        (4,) fx, fy, cx, cy.
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
        The board in the images, `None` where it is not known.
    note
        How it differs from the board that was given; empty if it does not.
    """

    lens: Lens
    width_px: int
    height_px: int
    intrinsics_px: FloatArray
    rms_px: float
    covariance: FloatArray
    image_names: tuple[str, ...]
    image_rms_px: FloatArray
    rejected: tuple[tuple[str, str], ...]
    coverage: NDArray[np.intp]
    board: BoardSpec | None
    note: str = ""

    @property
    def model(self) -> str:
        """Name of the lens model in files, as in ROS: ``plumb_bob`` is Brown's, ``equidistant`` OpenCV's fisheye."""
        return self.lens.model or self.lens.name

    @property
    def distortion(self) -> FloatArray:
        """(k,) coefficients of the lens."""
        return np.array(self.lens.coefficients)

    @property
    def sd(self) -> FloatArray:
        """(k,) standard deviation of intrinsics and distortion."""
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    @property
    def covered(self) -> float:
        """Share of the cells of the image that hold a point."""
        return float((self.coverage > 0).mean())

    def camera_spec(self, nominal: CameraSpec | None = None) -> CameraSpec:
        """The nominal camera's pose with this lens."""
        fx, fy, cx, cy = (float(value) for value in self.intrinsics_px)
        found = {
            "width_px": self.width_px,
            "height_px": self.height_px,
            "fx_px": fx,
            "fy_px": fy,
            "cx_px": cx,
            "cy_px": cy,
            "lens": self.lens.name,
            "distortion": self.lens.coefficients,
        }
        return CameraSpec(**{**(nominal or CameraSpec()).model_dump(), **found})
