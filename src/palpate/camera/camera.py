"""The camera: intrinsics and a lens, with a pose in the skin's frame.

    points_camera = camera_from_dome · (points_dome - origin)
    (u, v) = (cx + fx x_d, cy + fy y_d),   (x_d, y_d) = lens(x/z, y/z)

Behind a window (`palpate.camera.window`) a point is projected along its line of sight, which is refracted at two
planes. Nominally the camera's axes are the skin's: columns run along x, rows along y, and it looks up the axis.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from palpate.camera.arrays import array_module, as_array
from palpate.camera.lens import Lens
from palpate.camera.spec import CameraSpec
from palpate.camera.surface import Surface
from palpate.camera.window import Window
from palpate.core import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class Camera:
    """A camera below the skin.

    Attributes
    ----------
    spec, lens
        Its spec, and its lens.
    camera_from_dome
        (3, 3) rotation from the skin's frame to the camera's.
    origin
        (3,) pinhole in the skin's frame, mm.
    window
        Window between camera and markers; `None`: only air.
    """

    spec: CameraSpec
    lens: Lens
    camera_from_dome: FloatArray
    origin: FloatArray
    window: Window | None = None

    @property
    def width_px(self) -> int:
        """Width of the image, px."""
        return self.spec.width_px

    @property
    def height_px(self) -> int:
        """Height of the image, px."""
        return self.spec.height_px

    def project(self, points: ArrayLike) -> FloatArray:
        """Project points to pixels.

        Parameters
        ----------
        points
            (..., 3) in the skin's frame, mm; an array, or a torch tensor, through which it is differentiable.

        Returns
        -------
        ndarray
            (..., 2) column and row, px; NaN for points behind the camera; a tensor for tensors.
        """
        plane = self._on_unit_plane(points)
        scale, middle = (as_array(each, plane) for each in self._intrinsics())
        pixels: FloatArray = self.lens.distort(plane) * scale + middle
        return pixels

    def visible(self, points: ArrayLike, skin: Surface | None = None) -> BoolArray:
        """Test (...) whether points (..., 3) mm in the skin's frame are visible.

        A point is visible if it is in front of the camera, within the range where the lens does not fold, and inside
        the image. If `skin` is given, the line of sight must also pass through the opening of its base (radius B in
        the plane z = 0): the clamped rim hides parts that bulge beyond it. Occlusion by folds of the skin itself is
        not tested.
        """
        points = np.asarray(points, float)
        pixels = self.project(points)
        size = np.array([self.spec.width_px, self.spec.height_px])
        # pixel (0, 0) reaches from -0.5 to 0.5, as in OpenCV; NaN compares as not inside
        seen = np.all((pixels >= -0.5) & (pixels <= size - 0.5), axis=-1)
        seen &= np.linalg.norm(self._on_unit_plane(points), axis=-1) <= self.lens.max_radius
        if skin is not None:
            seen &= self._passes_opening(points, skin.base_radius)
        return np.asarray(seen)

    def back_project(self, pixels: ArrayLike) -> FloatArray:
        """Return the directions of pixels in air; `sight_lines` continues them behind a window.

        Parameters
        ----------
        pixels
            (..., 2) column and row, px.

        Returns
        -------
        ndarray
            (..., 3) unit vectors in the skin's frame, from `origin`.

        Raises
        ------
        PalpateError
            If the lens distortion folds before it reaches a pixel.
        """
        scale, middle = self._intrinsics()
        plane = self.lens.undistort((np.asarray(pixels, float) - middle) / scale)
        rays = np.concatenate([plane, np.ones((*plane.shape[:-1], 1))], axis=-1)
        directions = rays @ self.camera_from_dome
        return np.asarray(directions / np.linalg.norm(directions, axis=-1, keepdims=True))

    def sight_lines(self, pixels: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Return the lines of sight of pixels (..., 2) in the medium between camera and markers.

        Returns
        -------
        starts
            (..., 3) mm: the pinhole, or the points where the lines leave the window.
        rays
            (..., 3) unit vectors in the skin's frame.

        Raises
        ------
        PalpateError
            If the lens distortion folds before it reaches a pixel.
        """
        rays = self.back_project(pixels)
        if self.window is None:
            return np.broadcast_to(self.origin, rays.shape), rays
        return self.window.enter(self.origin, rays)

    def _intrinsics(self) -> tuple[FloatArray, FloatArray]:
        spec = self.spec
        return np.array([spec.fx_px, spec.fy_px]), np.array([spec.cx_px, spec.cy_px])

    def _on_unit_plane(self, points: ArrayLike) -> FloatArray:
        given = as_array(points)
        camera = self._arm(given) @ as_array(self.camera_from_dome, given).T
        depth = camera[..., 2:]
        plane: FloatArray = camera[..., :2] / array_module(given).where(depth > 0.0, depth, np.nan)
        return plane

    def _arm(self, points: FloatArray) -> FloatArray:
        """Return the vectors (..., 3) mm along which points are seen from the pinhole."""
        if self.window is not None:
            return self.window.aim(self.origin, points)
        return points - as_array(self.origin, points)

    def _passes_opening(self, points: FloatArray, radius: float) -> BoolArray:
        if self.window is not None:
            through, _ = self.window.enter(self.origin, self._arm(points))
            return np.asarray(np.linalg.norm(through[..., :2], axis=-1) <= radius)
        ray = points - self.origin
        rise = np.where(ray[..., 2] > 0.0, ray[..., 2], np.nan)
        crossing = self.origin[:2] - (self.origin[2] / rise)[..., None] * ray[..., :2]
        return np.asarray(np.linalg.norm(crossing, axis=-1) <= radius)
