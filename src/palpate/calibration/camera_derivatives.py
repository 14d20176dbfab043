"""Projection of points by a camera, and its derivatives by the points and by the camera."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from palpate.camera import Camera
from palpate.core import FloatArray


class Projection(NamedTuple):
    """Pixels (m, 2) of points, and their derivatives (m, 2, 3) px/mm by the points."""

    pixels: FloatArray
    by_point: FloatArray


def project_with_jacobian(camera: Camera, points: FloatArray, step: float = 1e-4) -> Projection:
    """Project points (m, 3) mm, with forward differences of `step` mm."""
    around = np.concatenate([points[None], points + step * np.eye(3)[:, None, :]])
    found = camera.project(around)
    return Projection(found[0], np.moveaxis((found[1:] - found[0]) / step, 0, -1))


class CameraDerivatives:
    """Derivatives of pixels by `palpate.calibration.unit_model.CAMERA_PARAMETERS`.

    A small motion of the camera is equal to the opposite motion of the markers. Points are therefore projected again
    only for a change of the lens, and for any change if there is a window, which does not move with the camera.

    `pairs` are cameras with each parameter increased and decreased by its step (10,).
    """

    def __init__(self, camera: Camera, pairs: list[tuple[Camera, Camera]], steps: FloatArray) -> None:
        self._camera, count = camera, len(pairs)
        self._turn, self._offset = np.zeros((3, 3, count)), np.zeros((3, count))
        self._scale, self._middle = np.zeros((2, count)), np.zeros((2, count))
        self._lenses: list[tuple[int, Camera, Camera, float]] = []
        for k, (high, low) in enumerate(pairs):
            twice = 2.0 * float(steps[k])
            if camera.window is not None or not high.lens == low.lens == camera.lens:
                self._lenses.append((k, high, low, twice))
                continue
            back = camera.camera_from_dome / twice
            self._turn[..., k] = (high.camera_from_dome - low.camera_from_dome).T @ back
            self._offset[:, k] = (high.camera_from_dome @ high.origin - low.camera_from_dome @ low.origin) @ back
            self._scale[:, k] = (_scale(high) - _scale(low)) / twice
            self._middle[:, k] = (_middle(high) - _middle(low)) / twice

    def jacobian(
        self, points: FloatArray, shown: Projection | None = None, carried: FloatArray | None = None
    ) -> FloatArray:
        """Return the derivatives (m, 2, 10) of the pixels of points (m, 3) mm.

        `shown` is the projection of the points, if known; `carried` (m, 3, 10) mm are the derivatives of the points
        themselves by the camera, if not zero.
        """
        pixels, by_point = shown or project_with_jacobian(self._camera, points)
        against = (points @ self._turn.reshape(3, -1)).reshape(-1, *self._turn.shape[1:]) - self._offset
        found = by_point @ (against if carried is None else carried + against)
        found += ((pixels - _middle(self._camera)) / _scale(self._camera))[..., None] * self._scale + self._middle
        for k, high, low, twice in self._lenses:
            found[..., k] += (high.project(points) - low.project(points)) / twice
        return np.asarray(found)


def _scale(camera: Camera) -> FloatArray:
    return np.array([camera.spec.fx_px, camera.spec.fy_px])


def _middle(camera: Camera) -> FloatArray:
    return np.array([camera.spec.cx_px, camera.spec.cy_px])
