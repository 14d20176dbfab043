"""The twin of one print under many walls at once, on torch: pixels of all dots for thousands of poses, on any device.

The same splines, waves and camera as `MarkerTwin.evaluate` and `Camera.project`, with the poses as the first axis of
every array, and with torch's derivatives through all of it. Walls are flat and come straight down.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from palpate.camera import Camera, Window
from palpate.core import FloatArray, PalpateError, load_extra
from palpate.twin.tensor_spline import BEYOND, DEGREE
from palpate.twin.twin import STRAIGHT_DEG, MarkerTwin

Tensor = Any
"""A torch.Tensor; torch is loaded where a `BatchTwin` is made."""
_NEWTON = 8
"""Iterations from the paraxial slope, of which four to five are needed."""
_PIECE = 4096
"""Poses at a time, which bounds the memory."""


class BatchTwin:
    """Pixels of a print's dots for many poses.

    Parameters
    ----------
    dots
        The print's twin.
    camera
        What sees it.
    corners
        How many places in turn are corners of one dot, seen where its trace has its centre, as in the outlines of a
        `UnitModel`; 1: each is a dot.
    thickness
        By how much the wall is thicker than designed, mm.
    device, dtype
        Of torch: ``"cpu"``, ``"cuda"``; ``"float64"`` or ``"float32"``.

    Raises
    ------
    MissingExtraError
        If torch is not installed.
    PalpateError
        If the camera's lens is known to no batch.
    """

    def __init__(
        self,
        dots: MarkerTwin,
        camera: Camera,
        corners: int = 1,
        thickness: float = 0.0,
        device: str = "cpu",
        dtype: str = "float64",
    ) -> None:
        self._torch = load_extra("torch", "learn")
        if camera.lens.name not in _LENSES:
            raise PalpateError(
                f"The lens {camera.lens.name} is not known to the twin in batch.",
                f"Take {' or '.join(_LENSES)}, or UnitModel.look pose by pose.",
                code="lens-not-in-batch",
            )
        self._kind = {"device": device, "dtype": getattr(self._torch, dtype)}
        self._camera, twin = camera, dots.twin
        half = twin.amplitudes.coefficients.shape[-1] // 3
        pressed = twin.amplitudes.coefficients[..., :half]
        if thickness:
            pressed = pressed + thickness * twin.amplitudes.coefficients[..., half : 2 * half]
        self._shape = pressed.shape[:3]
        self._knots = [self._tensor(knots) for knots in twin.amplitudes.knots]
        self._table, self._order = self._tensor(pressed.reshape(-1, half)), self._tensor(twin.order)
        self._waves, self._places = self._tensor(dots.waves.T), self._tensor(dots.places)
        self._corners = corners
        self._turn, self._origin = self._tensor(camera.camera_from_dome.T), self._tensor(camera.origin)
        spec = camera.spec
        self._scale = self._tensor(np.array([spec.fx_px, spec.fy_px]))
        self._middle = self._tensor(np.array([spec.cx_px, spec.cy_px]))

    def pixels(self, poses: Tensor | FloatArray, inverse_frictions: Tensor | FloatArray) -> Tensor:
        """Pixels (n, m, 2) of the dots.

        Parameters
        ----------
        poses
            (n, 3) rx, ry (degrees) and depth (mm).
        inverse_frictions
            (n,) 1/µ.
        """
        return self._in_pieces(lambda *each: self._centre(self._project(self._move(*each))), poses, inverse_frictions)

    def positions(self, poses: Tensor | FloatArray, inverse_frictions: Tensor | FloatArray) -> Tensor:
        """Positions (n, m, 3) mm of the dots; `poses` and `inverse_frictions` as for `pixels`."""
        return self._in_pieces(self._move, poses, inverse_frictions)

    def forces(self, poses: Tensor | FloatArray, inverse_frictions: Tensor | FloatArray) -> Tensor:
        """Forces (n, 3) N on the walls, in the dome's frame; `poses` and `inverse_frictions` as for `pixels`."""
        return self._in_pieces(self._force, poses, inverse_frictions)

    def _centre(self, pixels: Tensor) -> Tensor:
        """Centres (n, m, 2) of the traces whose corners these are (n, m k, 2)."""
        if self._corners == 1:
            return pixels
        x, y = pixels.unflatten(1, (-1, self._corners)).unbind(-1)
        nx, ny = x.roll(-1, -1), y.roll(-1, -1)
        cross = x * ny - nx * y
        moments = self._torch.stack([((x + nx) * cross).sum(-1), ((y + ny) * cross).sum(-1)], dim=-1)
        return moments / (3.0 * cross.sum(-1, keepdim=True))

    def _in_pieces(self, does: Callable[..., Tensor], poses: Any, inverse_frictions: Any) -> Tensor:
        poses, inverse_frictions = self._tensor(poses), self._tensor(inverse_frictions)
        pieces = zip(poses.split(_PIECE), inverse_frictions.split(_PIECE), strict=True)
        return self._torch.cat([does(*piece) for piece in pieces])

    def _tensor(self, values: Any) -> Tensor:
        return self._torch.as_tensor(values, **self._kind)

    def _amplitudes(self, poses: Tensor, inverse_frictions: Tensor) -> tuple[Tensor, Tensor]:
        """Amplitudes (n, r + 3) of modes and force, and azimuths (n,) of the tilts."""
        torch = self._torch
        tilt = torch.hypot(poses[:, 0], poses[:, 1]).clamp(min=STRAIGHT_DEG)
        first, weight = self._basis(0, inverse_frictions)
        for axis, at in ((1, tilt), (2, poses[:, 2])):
            number, share = self._basis(axis, at)
            first = (first[:, :, None] * self._shape[axis] + number[:, None, :]).flatten(1)
            weight = (weight[:, :, None] * share[:, None, :]).flatten(1)
        found = torch.nn.functional.embedding_bag(first, self._table, mode="sum", per_sample_weights=weight)
        return found, torch.atan2(poses[:, 1], poses[:, 0])

    def _basis(self, axis: int, at: Tensor) -> tuple[Tensor, Tensor]:
        """Numbers (n, 4) of the B-splines that live at places (n,) of an axis, and their values."""
        torch, knots = self._torch, self._knots[axis]
        last = len(knots) - DEGREE - 2
        end = knots[last + 1] + BEYOND * (knots[last + 1] - knots[last])
        at = torch.minimum(torch.maximum(at, knots[DEGREE]), end)
        span = (torch.searchsorted(knots, at.detach().contiguous(), right=True) - 1).clamp(DEGREE, last)
        values = [torch.ones_like(at)]
        for degree in range(1, DEGREE + 1):
            saved, raised = torch.zeros_like(at), []
            for k, value in enumerate(values):
                right, left = knots[span + k + 1] - at, at - knots[span + k + 1 - degree]
                share = value / (right + left)
                raised.append(saved + right * share)
                saved = left * share
            values = [*raised, saved]
        steps = torch.arange(DEGREE + 1, device=span.device)
        return span[:, None] - DEGREE + steps, torch.stack(values, dim=1)

    def _move(self, poses: Tensor, inverse_frictions: Tensor) -> Tensor:
        found, azimuth = self._amplitudes(poses, inverse_frictions)
        modes, angle = found[:, : len(self._order)], azimuth[:, None] * self._order
        rows = self._torch.cat([modes * angle.cos(), modes * angle.sin()], dim=1)
        return self._places + (rows @ self._waves).reshape(len(poses), -1, 3)

    def _force(self, poses: Tensor, inverse_frictions: Tensor) -> Tensor:
        found, azimuth = self._amplitudes(poses, inverse_frictions)
        slope, axial, axis = found[:, len(self._order) :].T
        c, s = azimuth.cos(), azimuth.sin()
        return self._torch.stack([axis * c - slope * s, slope * c + axis * s, axial], dim=1)

    def _project(self, points: Tensor) -> Tensor:
        window = self._camera.window
        arm = points - self._origin if window is None else _aim(self._torch, window, self._origin, points)
        seen = arm @ self._turn
        lens = self._camera.lens
        plane = _LENSES[lens.name](self._torch, seen[..., :2] / seen[..., 2:], lens.coefficients)
        return plane * self._scale + self._middle


def _aim(torch: Any, window: Window, origin: Tensor, points: Tensor) -> Tensor:
    """`palpate.camera.Window.aim` in torch; a last step of Newton's iteration carries its derivative."""
    rise = (points[..., 2] - origin[2]).clamp(min=1e-6)
    across = points[..., :2] - origin[:2]
    reach = across.norm(dim=-1).clamp(min=1e-9)
    air = torch.minimum(rise, -window.thickness - origin[2])
    behind = (points[..., 2] + window.thickness).clamp(0.0, window.thickness), points[..., 2].clamp(min=0.0)
    layers = [(air, 1.0), *zip(behind, (window.index**2, window.gel_index**2), strict=True)]

    def step(slope: Tensor) -> Tensor:
        bends = [(height, square, (square + (square - 1.0) * slope**2).rsqrt()) for height, square in layers]
        miss = reach - slope * sum(height * bend for height, _, bend in bends)
        return slope + miss / sum(height * square * bend**3 for height, square, bend in bends).detach()

    with torch.no_grad():
        slope = reach / sum(height / square**0.5 for height, square in layers)
        for _ in range(_NEWTON):
            slope = step(slope)
    slope = step(slope)
    return torch.cat([across * (slope / reach * rise)[..., None], rise[..., None]], dim=-1)


def _brown(torch: Any, points: Tensor, coefficients: tuple[float, ...]) -> Tensor:
    """`palpate.camera.lenses.brown` in torch."""
    if not any(coefficients):
        return points
    k1, k2, p1, p2, k3 = coefficients
    x, y = points[..., 0], points[..., 1]
    square = x * x + y * y
    radial = 1.0 + square * (k1 + square * (k2 + square * k3))
    across = x * radial + 2.0 * p1 * x * y + p2 * (square + 2.0 * x * x)
    down = y * radial + p1 * (square + 2.0 * y * y) + 2.0 * p2 * x * y
    return torch.stack([across, down], dim=-1)


def _kannala_brandt(torch: Any, points: Tensor, coefficients: tuple[float, ...]) -> Tensor:
    """`palpate.camera.lenses.kannala_brandt` in torch."""
    radius = points.norm(dim=-1, keepdim=True).clamp(min=1e-12)
    angle = radius.atan()
    square, series = angle * angle, 0.0
    for coefficient in reversed(coefficients):
        series = square * (coefficient + series)
    return points * angle * (1.0 + series) / radius


_LENSES: dict[str, Callable[[Any, Tensor, tuple[float, ...]], Tensor]] = {
    "brown": _brown,
    "kannala-brandt": _kannala_brandt,
}
