"""Presses of a skin with the mirrors x → −x and y → −y at any tilt, azimuth and depth of a wall.

Only a rotation by half a turn leaves such a skin unchanged, so every tilt is pressed at azimuths from 0 to 90° in
equal steps. With M the mirror x → −x, a marker at p moves by

    u(p; rx, ry) = M u(M p; rx, −ry)

since a rotation axis is an axial vector: its component normal to the mirror is kept, that along the mirror is
reversed. So azimuth α becomes −α, in the mirror y → −y it becomes 180° − α, and in both α + 180°. Between tilts every
azimuth has a cubic spline (see `tilt_runs`). It ends at the untilted press, since a wall of opposite tilt touches a
flat pad at its opposite side, which is a kink. Between the n azimuths a quantity is the trigonometric polynomial
through them

    u(t, α) = Re Σ_k c_k(t) exp(i k α),      k = 0 … n/2 .

The position of the wall, not its depth since first contact, is smooth over tilts and azimuths: a wall that rotates
away from a side of a pad changes to a corner at once. With Z(t, α) the height at which a wall at first contact
crosses the axis, presses are therefore interpolated at one height of the wall over the axis, the *level*

    l = d - Z(t, α) + Z(0)

of the depth d, below 0 where the wall is not yet down to the top. A press is at level l by the cubic spline through
its increments; between levels, half a depth step apart, by the cubic through four of them. So depths end short of the
presses: at tilts up to t by as much as the presses at t touch higher than those at the tilt before.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self, final

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray, PalpateError
from palpate.design import Skin, rotation_vector, wall_normal
from palpate.fea import Press
from palpate.mechanics import EndReason
from palpate.mesh import Mesh, mesh_skin
from palpate.surrogate.press_field import NodalRead, PressField, Series, find_nodes, wall_nodes
from palpate.surrogate.tilt_runs import (
    SAME_DEPTH_MM,
    TiltRuns,
    cut_into_runs,
    interpolate_depths,
    label_presses,
    shared_depths,
)

MIRRORS = np.array([[1, 1, 1], [-1, 1, 1], [1, -1, 1], [-1, -1, 1]])
"""(4, 3) factors of x, y and z: nothing, x → −x, y → −y, and both."""
_DECIMALS = 6
"""Digits of an azimuth in degrees."""
_CUBIC = 4
"""Levels between which one is interpolated."""
_NOT_SO_DEEP = "not pressed so deep at every azimuth"
"""Reason for a missing increment although all presses reached their depth."""
_TURNS = np.linspace(0.0, np.pi / 2, 181)
"""Azimuths in rad among which the highest and the lowest first contact are searched."""
_LEVELS = 2
"""Levels a depth step. By hand."""


@final
@dataclass(frozen=True, eq=False)
class TwoMirrorField(PressField):
    """Presses of a skin with two mirrors under walls, by tilt and azimuth.

    Attributes
    ----------
    rows
        (t, a) presses by ascending tilt, each row by azimuths of 0 to 90°; the straight press at all of them.
    azimuths_deg
        (a,) degrees.
    levels_mm
        (l,) levels at which presses are interpolated, evenly spaced.
    levels
        Runs of tilts at each level, whose splines give the shares (t,) of the solved tilts.
    """

    rows: tuple[tuple[Press, ...], ...]
    azimuths_deg: tuple[float, ...]
    levels_mm: FloatArray
    levels: TiltRuns

    @classmethod
    def of(cls, presses: Sequence[Press], depths_mm: FloatArray | None = None) -> Self:
        """Arrange presses, one at every azimuth of each tilt; see `palpate.surrogate.build_field`.

        Raises
        ------
        PalpateError
            If the obstacle does not tilt, the azimuths are not 0 to 90° in equal steps, or a press is missing.
        """
        table, azimuths = _sort_presses(presses)
        tilts, skin = np.array(sorted({tilt for tilt, _ in table})), presses[0].mesh.skin
        rows = tuple(tuple(table[tilt, azimuth] for azimuth in azimuths) for tilt in tilts)
        solved = max((shared_depths(column) for column in zip(*rows, strict=True)), key=len)
        touch = np.array([first_touch(skin, np.full(len(_TURNS), tilt), _TURNS) for tilt in tilts])
        step, count = solved[0] / _LEVELS, len(tilts)
        levels = np.asarray(step * np.arange(-np.ceil(touch.max() / step), _LEVELS * len(solved) + 1))
        known = _reached(rows, azimuths, levels)
        shares = np.broadcast_to(np.eye(count), (len(levels), count, count))
        depths = solved if depths_mm is None else depths_mm
        before = np.concatenate([touch[:1], touch[:-1]]).min(axis=1)
        needed = np.ceil((depths[:, None] - before - SAME_DEPTH_MM - levels[0]) / (levels[1] - levels[0]))
        return cls(
            tuple(presses),
            depths,
            _label(rows, tilts, depths, needed < known.sum(axis=0)),
            np.empty((0, 3)),
            rows,
            azimuths,
            levels,
            cut_into_runs(tilts, np.where(known, "known", ""), [""] * count, shares, None),
        )

    @cached_property
    def moved(self) -> Series:
        points = (MIRRORS[:, None] * self.rest).reshape(-1, 3)

        def follow(press: Press) -> FloatArray:
            moved = press.displacement_at(points)
            return np.asarray(moved.reshape(len(moved), 4, *self.rest.shape) * MIRRORS[:, None])

        return self._series(follow)

    @cached_property
    def force(self) -> Series:
        return self._series(lambda press: press.force[:, None] * MIRRORS)

    def nodal(self, mesh: Mesh, read: NodalRead, *, linear: bool) -> Series:
        nodes = wall_nodes(mesh)
        images = np.stack([find_nodes(nodes, mirror * nodes) for mirror in MIRRORS])
        half = mesh_skin(mesh.skin, mesh.spec.model_copy(update={"whole": False}))
        folded = find_nodes(wall_nodes(half), np.column_stack([np.abs(nodes[:, 0]), nodes[:, 1:]]))

        def follow(press: Press) -> FloatArray:
            if press.mesh.spec.whole:
                values = read(press, mesh)
            else:
                values = read(press, half)[:, folded]
                if values.shape[-1] == 3:
                    values[:, nodes[:, 0] < 0] *= MIRRORS[1]
            seen = values[:, images]
            return seen * MIRRORS[:, None] if values.shape[-1] == 3 else seen

        return self._series(follow)

    def _series(self, follow: Callable[[Press], FloatArray]) -> Series:
        """A quantity at all levels; `follow` gives it of a press's increments and mirror images, (i, 4, …)."""
        around = []
        for row in self.rows:
            late = zip(row, _late(row, self.azimuths_deg), strict=True)
            seen = (interpolate_depths(press, follow(press), self.levels_mm + by) for press, by in late)
            around.append(_all_azimuths([np.moveaxis(values, 1, 0) for values in seen]))
        return _TwoMirrorSeries(self, np.nan_to_num(np.stack(around, axis=1)))


@dataclass(frozen=True, eq=False)
class _TwoMirrorSeries:
    """One quantity (l, t, n, …) of all presses by level and azimuth 0, 360°/n, …; 0 at unknown levels."""

    field: TwoMirrorField
    values: FloatArray

    def at(self, tilt_deg: FloatArray, azimuth: FloatArray, depth_index: int) -> FloatArray:
        depth = float(self.field.depths_mm[depth_index])
        deep = depth - first_touch(self.field.presses[0].mesh.skin, tilt_deg, azimuth)
        first, shares = _between_levels(deep, self.field.levels_mm)
        found = np.zeros((len(tilt_deg), *self.values.shape[3:]))
        for level, values in enumerate(self.values) if depth else ():
            inside = (level >= first) & (level < first + _CUBIC)
            share = np.where(inside, shares[np.arange(len(deep)), np.clip(level - first, 0, _CUBIC - 1)], 0.0)
            used = np.flatnonzero(share)
            for chosen, tilts in self.field.levels.read(tilt_deg[used], level):
                here = used[chosen]
                around = share[here, None] * between_azimuths(azimuth[here], values.shape[1])
                found[here] += np.tensordot(tilts[:, :, None] * around[:, None, :], values, axes=2)
        found[self.field.labels(tilt_deg, depth_index)[0] == ""] = np.nan
        return found


def _sort_presses(presses: Sequence[Press]) -> tuple[Mapping[tuple[float, float], Press], tuple[float, ...]]:
    """Presses by tilt and azimuth in degrees, the straight one at every azimuth; and the azimuths."""
    if not all(press.obstacle.pose_space.is_tilt for press in presses):
        raise PalpateError(
            "Presses of a skin other than a body of revolution are interpolated under flat walls only.",
            "Read single presses of other obstacles.",
            code="azimuths-need-flat-wall",
        )
    table: dict[tuple[float, float], Press] = {}
    azimuths = _azimuths(presses)
    for press in presses:
        tilt, azimuth = press.obstacle.radial, round(press.obstacle.turn_deg, _DECIMALS)
        for place in [(tilt, azimuth)] if tilt > 0 else [(tilt, each) for each in azimuths]:
            if place in table:
                raise PalpateError(
                    f"The tilt {tilt:g}° at {place[1]:g}° was given twice.",
                    "Keep one press a pose.",
                    code="tilt-twice",
                )
            table[place] = press
    tilts = sorted({tilt for tilt, _ in table})
    missing = [f"{tilt:g}° at {each:g}°" for tilt in tilts for each in azimuths if (tilt, each) not in table]
    if missing:
        raise PalpateError(
            f"Presses are missing: the tilt {', '.join(missing)}.",
            "Press every tilt at every one of the azimuths.",
            code="presses-missing",
        )
    return table, azimuths


def _azimuths(presses: Sequence[Press]) -> tuple[float, ...]:
    found = tuple(
        sorted({round(press.obstacle.turn_deg, _DECIMALS) for press in presses if press.obstacle.radial > 0})
    )
    even = np.linspace(0.0, 90.0, len(found))
    if len(found) < 2 or not np.allclose(found, even, atol=10.0**-_DECIMALS):
        given = ", ".join(f"{each:g}" for each in found)
        raise PalpateError(
            f"Presses at the azimuths {given or '(none)'}° do not determine the rest of {presses[0].mesh.skin.name}.",
            "Press every tilt from 0 to 90° in equal steps, such as 0, 30, 60 and 90°.",
            code="azimuths-incomplete",
        )
    return found


def _reached(rows: Sequence[Sequence[Press]], azimuths_deg: Sequence[float], levels_mm: FloatArray) -> BoolArray:
    """Whether all presses of a tilt reached a level, (l, t)."""
    reached = np.array([[float(press.depth.max()) for press in row] for row in rows])
    late = np.array([_late(row, azimuths_deg) for row in rows])
    return np.asarray((levels_mm[:, None, None] + late <= reached + SAME_DEPTH_MM).all(axis=2))


def _late(row: Sequence[Press], azimuths_deg: Sequence[float]) -> FloatArray:
    """(a,) mm by which first contact of the presses of one tilt is higher than that of the untilted one."""
    return first_touch(row[0].mesh.skin, np.full(len(row), row[0].obstacle.radial), np.radians(azimuths_deg))


def _label(
    rows: Sequence[Sequence[Press]], tilts_deg: FloatArray, depths_mm: FloatArray, reached: BoolArray
) -> TiltRuns:
    """Runs of tilts of presses that share a branch and reached the depths, (d, t)."""
    labels = np.array([label_presses(column, depths_mm) for column in zip(*rows, strict=True)])
    reached = reached | (depths_mm[:, None] == 0)
    branch = np.where(reached & (labels == labels[0]).all(axis=0), labels[0], "")
    first = [min(row, key=lambda press: press.ended_depth) for row in rows]
    ended = [_NOT_SO_DEEP if press.ended is EndReason.DEPTH_REACHED else str(press.ended) for press in first]
    return cut_into_runs(tilts_deg, branch, ended, np.zeros((*branch.shape, 1)), None)


def _all_azimuths(quarter: Sequence[FloatArray]) -> FloatArray:
    """Values (d, n, …) at n azimuths from those (4, d, …) of presses at 0 to 90° and mirror images."""
    half = 2 * (len(quarter) - 1)
    around = np.empty((quarter[0].shape[1], 2 * half, *quarter[0].shape[2:]))
    for number, seen in enumerate(quarter):
        places = (number, -number, half - number, half + number)
        for place in {place % (2 * half) for place in places}:
            same = [k for k in range(4) if places[k] % (2 * half) == place]
            around[:, place] = seen[same].mean(axis=0)
    return around


def first_touch(skin: Skin, tilt_deg: FloatArray, azimuth: FloatArray) -> FloatArray:
    """Z - Z(0) (n,) mm of tilts (n,) in degrees at azimuths (n,) in rad."""
    turns = rotation_vector(np.radians(tilt_deg), azimuth)
    normals = np.array([wall_normal(*turn) for turn in turns.tolist()]).reshape(-1, 3)
    return skin.support_height(normals) - skin.outer_height


def between_azimuths(azimuth: FloatArray, count: int) -> FloatArray:
    """Weights (n, count) of evenly spaced azimuths (an even number, from 0) at azimuths (n,) in rad.

    Weights of trigonometric interpolation: ``(1 + 2 Σ cos k x + cos (count x / 2)) / count`` with x the difference of
    the azimuths, and k below half their number.
    """
    apart = azimuth[:, None] - 2 * np.pi * np.arange(count) / count
    waves = 2.0 * np.cos(np.arange(1, count // 2) * apart[..., None]).sum(axis=-1)
    return np.asarray((1.0 + waves + np.cos(count // 2 * apart)) / count)


def _between_levels(deep: FloatArray, levels: FloatArray) -> tuple[IntArray, FloatArray]:
    """Index of the first of four levels (n,), and Lagrange weights (n, 4), at places (n,) mm."""
    place = (deep - levels[0]) / (levels[1] - levels[0])
    first = np.clip(np.ceil(place - 1e-9).astype(int) - _CUBIC + 1, 0, max(len(levels) - _CUBIC, 0))
    at = place - first
    others = [[k for k in range(_CUBIC) if k != own] for own in range(_CUBIC)]
    shares = [np.prod([(at - k) / (own - k) for k in others[own]], axis=0) for own in range(_CUBIC)]
    return first, np.column_stack(shares)
