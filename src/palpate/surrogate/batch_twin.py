"""Batched evaluation of a marker twin on torch: pixels of all markers for many poses, on any device.

The splines and waves are those of `MarkerTwin.evaluate`, with the poses as the first axis of every array, followed by
`Camera.project` and torch's derivatives through both. Walls are flat and approach without lateral motion.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any

from palpate.camera import Camera, project_markers
from palpate.core import FloatArray, PalpateError, load_extra
from palpate.surrogate.tensor_spline import BEYOND, DEGREE
from palpate.surrogate.twin import STRAIGHT_DEG, MarkerTwin, refuse_left_out

Tensor = Any
"""A torch.Tensor; torch is imported on the construction of a `BatchTwin`."""
_PIECE = {"cpu": 1 << 12, "cuda": 1 << 17}
"""Poses per piece by device, limited by memory: 3 GB on a GPU for 169 markers."""


class BatchTwin:
    """Pixels of the markers of a layout for many poses.

    Parameters
    ----------
    marker_twin
        The layout's twin.
    camera
        The camera.
    corners
        Number of successive places that are corners of one marker, read at the centroid of its projected outline as
        by a `UnitModel`; 1: each place is a marker.
    thickness
        Deviation of the skin thickness, mm.
    device, dtype
        Torch device and type: ``"cpu"``, ``"cuda"``; ``"float64"`` or ``"float32"``.

    Raises
    ------
    MissingExtraError
        If torch is not installed.
    PalpateError
        If the camera's lens does not support tensors, or the twin leaves the thickness out.
    """

    def __init__(
        self,
        marker_twin: MarkerTwin,
        camera: Camera,
        corners: int = 1,
        thickness: float = 0.0,
        device: str = "cpu",
        dtype: str = "float64",
    ) -> None:
        self._torch = load_extra("torch", "learn")
        self._kind = {"device": device, "dtype": getattr(self._torch, dtype)}
        self._camera, twin = camera, marker_twin.twin
        half = twin.amplitudes.coefficients.shape[-1] // 3
        pressed = twin.amplitudes.coefficients[..., :half]
        if thickness:
            refuse_left_out(twin, (thickness,))
            pressed = pressed + thickness * twin.amplitudes.coefficients[..., half : 2 * half]
        self._shape = pressed.shape[:3]
        self._knots = [self._tensor(knots) for knots in twin.amplitudes.knots]
        self._table, self._order = self._tensor(pressed.reshape(-1, half)), self._tensor(twin.order)
        self._waves, self._places = self._tensor(marker_twin.waves.T), self._tensor(marker_twin.places)
        self._corners = corners
        with suppress(TypeError, RuntimeError):  # a lens from another package may be of numpy alone
            if self._torch.is_tensor(camera.project(self._places)):
                return
        raise PalpateError(
            f"The lens {camera.lens.name} distorts no tensors of torch.",
            "Write its `distort` with operators, or use UnitModel.predict pose by pose.",
            code="lens-not-in-batch",
        )

    def evaluate(self, poses: Tensor | FloatArray, inverse_frictions: Tensor | FloatArray) -> tuple[Tensor, Tensor]:
        """Compute pixels (n, m, 2) of the markers and forces (n, 3) N on the walls, in the frame of the skin.

        Parameters
        ----------
        poses
            (n, 3) rx, ry (degrees) and depth (mm). A tensor on the twin's device is not copied.
        inverse_frictions
            (n,) 1/µ.
        """
        return self._in_pieces(poses, inverse_frictions, self._see, self._force)

    def pixels(self, poses: Tensor | FloatArray, inverse_frictions: Tensor | FloatArray) -> Tensor:
        """Compute pixels (n, m, 2) of the markers; arguments as for `evaluate`."""
        return self._in_pieces(poses, inverse_frictions, self._see)[0]

    def positions(self, poses: Tensor | FloatArray, inverse_frictions: Tensor | FloatArray) -> Tensor:
        """Compute positions (n, m, 3) mm of the markers; arguments as for `evaluate`."""
        return self._in_pieces(poses, inverse_frictions, self._move)[0]

    def forces(self, poses: Tensor | FloatArray, inverse_frictions: Tensor | FloatArray) -> Tensor:
        """Compute forces (n, 3) N on the walls, in the frame of the skin; arguments as for `evaluate`."""
        return self._in_pieces(poses, inverse_frictions, self._force)[0]

    def _see(self, found: Tensor, azimuth: Tensor) -> Tensor:
        points = self._move(found, azimuth)
        if self._corners == 1:
            return self._camera.project(points)
        return project_markers(self._camera, points.reshape(len(points), -1, self._corners, 3)).centres

    def _in_pieces(self, poses: Any, inverse_frictions: Any, *results: Callable[[Tensor, Tensor], Tensor]) -> Any:
        """Evaluate results (n, …) from the amplitudes and azimuths of the poses, in pieces."""
        poses, inverse_frictions = self._tensor(poses), self._tensor(inverse_frictions)
        size = _PIECE.get(self._kind["device"].split(":")[0], _PIECE["cpu"])
        parts = []
        for piece in zip(poses.split(size), inverse_frictions.split(size), strict=True):
            state = self._amplitudes(*piece)
            parts.append([result(*state) for result in results])
        return tuple(self._torch.cat(one) if len(one) > 1 else one[0] for one in zip(*parts, strict=True))

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
        """Indices (n, 4) of the nonzero B-splines at places (n,) of an axis, and their values."""
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

    def _move(self, found: Tensor, azimuth: Tensor) -> Tensor:
        modes, angle = found[:, : len(self._order)], azimuth[:, None] * self._order
        rows = self._torch.cat([modes * angle.cos(), modes * angle.sin()], dim=1)
        return self._places + (rows @ self._waves).reshape(len(found), -1, 3)

    def _force(self, found: Tensor, azimuth: Tensor) -> Tensor:
        slope, axial, axis = found[:, len(self._order) :].T
        c, s = azimuth.cos(), azimuth.sin()
        return self._torch.stack([axis * c - slope * s, slope * c + axis * s, axial], dim=1)
