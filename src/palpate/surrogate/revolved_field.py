"""Presses of a body of revolution at any pose.

One press serves every azimuth: a half model turns with the wall, and points on circles by their Fourier series (see
`circle`). Between tilts everything is a cubic spline (see `tilt_runs`). A wall tilted by −t is the wall tilted by t
seen in the mirror y → −y of the tilt's frame, and that wall turned by half a turn, hence the parities

    u(x, y, z; −t) = M u(x, −y, z; t),      M = diag(1, −1, 1);      c_k(−t) = (−1)^k c_k(t)

of nodal fields u and of Fourier coefficients c_k; of the force, the parts up the slope and along the axis of the tilt
change sign. The same holds for a ball offset by −t. A wall that moves up its slope, or a plate whose hole lies off
the axis, depends on the azimuth at tilt 0; its splines end there. Below, the *tilt* of an obstacle that does not tilt
is its offset in mm.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self, final

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray
from palpate.fea import Press
from palpate.mesh import Mesh
from palpate.surrogate.circle import ORDERS, expand_press, sort_onto_circles, sum_series
from palpate.surrogate.press_field import NodalRead, PressField, Series, find_nodes, wall_nodes
from palpate.surrogate.tilt_runs import TiltRuns, cut_into_runs, label_presses, match_depths, shared_depths

SLOPE = "tilt_deg"
"""Derivative with which presses are interpolated by value and slope, if all of them have it."""
_FORCE_PARITY = np.array([-1.0, 1.0, -1.0])
_ACROSS = np.array([1.0, -1.0, 1.0])


@final
@dataclass(frozen=True, eq=False)
class RevolvedField(PressField):
    """Presses of a body of revolution, by ascending tilt."""

    @classmethod
    def of(cls, presses: Sequence[Press], depths_mm: FloatArray | None = None) -> Self:
        """Arrange presses, one a tilt; see `palpate.surrogate.build_field`."""
        depths = shared_depths(presses) if depths_mm is None else depths_mm
        presses = tuple(sorted(presses, key=lambda press: press.obstacle.radial))
        tilts = np.array([press.obstacle.radial for press in presses], dtype=float)
        branch, ended = label_presses(presses, depths), [str(press.ended) for press in presses]
        labels = cut_into_runs(tilts, branch, ended, np.zeros((*branch.shape, 1)), None)
        return cls(presses, depths, labels, np.empty((0, 3)))

    @cached_property
    def moved(self) -> Series:
        circles, turn_deg = sort_onto_circles(self.rest), self.space.turn_deg
        values = self._gather(lambda press: expand_press(press, circles))
        slopes = self._gather(lambda press: expand_press(press, circles, by=SLOPE)) if self._sloped else None
        runs = self._cut(values, (-1.0) ** np.arange(ORDERS) * values, slopes)

        def turn(series: NDArray[Any], azimuth: FloatArray, _: int) -> FloatArray:
            return sum_series(series, azimuth + np.radians(turn_deg), circles)

        return _RevolvedSeries(runs, turn, self.rest.shape)

    @cached_property
    def force(self) -> Series:
        parts = self._gather(lambda press: forces_along_tilt(press, press.force))

        def turn(parts: NDArray[Any], azimuth: FloatArray, _: int) -> FloatArray:
            (slope, axial, axis), c, s = parts.T, np.cos(azimuth), np.sin(azimuth)
            return np.column_stack([axis * c - slope * s, slope * c + axis * s, axial])

        return _RevolvedSeries(self._cut(parts, _FORCE_PARITY * parts), turn, (3,))

    def nodal(self, mesh: Mesh, read: NodalRead, *, linear: bool) -> Series:
        nodes, sloped = wall_nodes(mesh), linear and self._sloped
        across = find_nodes(nodes, nodes * _ACROSS)

        def follow(press: Press) -> NDArray[np.float32]:
            """The field (i, 2 or 3, n, c) of a press, of its mirror image, and its derivative by the tilt."""
            own = read(press, mesh)
            parts = [own, own[:, across] * (_ACROSS if own.shape[-1] == len(_ACROSS) else 1.0)]
            if sloped:
                parts.append(read(replace(press, displacement=press.derivatives[SLOPE].displacement), mesh))
            return np.stack(parts, axis=1).astype(np.float32)

        values = self._gather(follow).swapaxes(1, 2)
        depths, parts, count = values.shape[:3]
        # the splines give the shares (parts, t) that the presses have, as those of all nodes would fill the memory
        share = np.zeros((3, count, parts, count))
        for k in range(parts):
            share[k, :, k] = np.eye(count)
        own, mirrored, slope = (np.broadcast_to(each, (depths, *each.shape)) for each in share)
        known = np.isfinite(values[:, -1]).all(axis=(2, 3))[..., None, None]
        runs = self._cut(own, mirrored, np.where(known, slope, np.nan) if sloped else None)
        values = np.nan_to_num(values)

        def blend(shares: NDArray[Any], _: FloatArray, depth_index: int) -> FloatArray:
            return np.tensordot(shares.astype(np.float32), values[depth_index], axes=2)

        return _RevolvedSeries(runs, blend, values.shape[3:])

    @property
    def _sloped(self) -> bool:
        return all(SLOPE in press.derivatives for press in self.presses)

    def _gather(self, read: Callable[[Press], NDArray[Any]]) -> NDArray[Any]:
        """A quantity (i, …) of each press at the common depths: (d, t, …), NaN below the end of a press."""
        fields = [read(press) for press in self.presses]
        gathered = np.full((*self.runs.branch.shape, *fields[0].shape[1:]), np.nan, fields[0].dtype)
        for column, (press, values) in enumerate(zip(self.presses, fields, strict=True)):
            depth, image = match_depths(self.depths_mm, press)
            gathered[depth, column] = values[image]
        return gathered

    def _cut(self, values: NDArray[Any], mirrored: NDArray[Any], slopes: NDArray[Any] | None = None) -> TiltRuns:
        opposite = mirrored if all(press.obstacle.centred for press in self.presses) else None
        return cut_into_runs(self.runs.tilts_deg, self.runs.branch, self.runs.ended, values, opposite, slopes)


@dataclass(frozen=True, eq=False)
class _RevolvedSeries:
    """One quantity: splines over the tilt, evaluated to (n, *shape) at azimuths (n,) and a depth."""

    runs: TiltRuns
    turn: Callable[[NDArray[Any], FloatArray, int], FloatArray]
    shape: tuple[int, ...]

    def at(self, tilt_deg: FloatArray, azimuth: FloatArray, depth_index: int) -> FloatArray:
        found = np.full((len(tilt_deg), *self.shape), np.nan)
        for chosen, values in self.runs.read(tilt_deg, depth_index):
            found[chosen] = self.turn(values, azimuth[chosen], depth_index)
        return found


def forces_along_tilt(press: Press, force: FloatArray) -> FloatArray:
    """Convert forces (n, 3) N from the skin's frame to up the slope, along the skin's and tilt's axes."""
    azimuth = np.radians(press.obstacle.turn_deg)
    c, s = np.cos(azimuth), np.sin(azimuth)
    return np.stack([force[:, 1] * c - force[:, 0] * s, force[:, 2], force[:, 0] * c + force[:, 1] * s], axis=-1)
