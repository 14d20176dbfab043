"""Calibration of a camera: its lens, the uncertainty, and the data of the fit."""

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
    """Result of a camera calibration.

    Attributes
    ----------
    lens
        The lens.
    width_px, height_px
        Size of the images.
    intrinsics_px
        (4,) fx, fy, cx, cy.
    rms_px
        Root mean square distance between detected and projected points.
    covariance
        (k, k) of intrinsics and distortion, from the residuals; NaN if the model does not provide it.
    image_names, image_rms_px
        Used images, and the root mean square distance of each.
    rejected
        Images that were not used, with the reason.
    coverage
        (6, 8) number of points in each cell of the image, from its top left corner.
    board, note
        The board in the images, `None` if unknown, and its difference from the given one; empty if equal.
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
        """Name of the lens model in files, as in ROS: ``plumb_bob`` (Brown), ``equidistant`` (fisheye)."""
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
        """Share of the cells of the image that contain a point."""
        return float((self.coverage > 0).mean())

    def camera_spec(self, nominal: CameraSpec | None = None) -> CameraSpec:
        """Return a camera with the nominal pose and this lens."""
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
