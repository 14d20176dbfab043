"""What presses of a skin with the mirrors x → −x and y → −y have at any tilt, azimuth and depth of a wall.

No turn but half a one leaves such a skin as it is, so every tilt is pressed at azimuths from 0 to 90° in equal steps.
The mirrors give the others (`palpate.twin.turned_presses`). Between tilts every azimuth has a cubic spline (see
`tilt_runs`); it ends at the straight press, for a wall that tilts the other way touches a flat pad at its other side,
which is a kink. Between the n azimuths what is asked for is the trigonometric polynomial through them

    u(t, α) = Re Σ_k c_k(t) exp(i k α),      k = 0 … n/2 .

What is smooth over tilts and azimuths is where the wall is, not how far it has come since first touch: a wall that
turns away from a side of a pad leaves it for a corner at once. With Z(t, α) the height at which a wall that first
touches crosses the axis, presses are therefore interpolated at one height of the wall over the axis, the *level*

    l = d - Z(t, α) + Z(0)

of the depth d, below 0 where the wall is not yet down to the top. A press is at level l by the cubic spline through
its images; between levels, half an image step apart, by the cubic through four of them. So images end short of the
presses: at tilts up to t by as much as the presses at t touch higher than those at the tilt before.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray
from palpate.design import Skin, rotation_vector, wall_normal
from palpate.fea import Press
from palpate.mechanics import EndReason
from palpate.twin.tilt_runs import SAME_DEPTH_MM, TiltRuns, cut_into_runs, label_presses, shared_depths
from palpate.twin.turned_presses import all_azimuths, at_depths, sort_presses

_CUBIC = 4
"""Levels between which one is interpolated."""
_NOT_SO_DEEP = "not pressed so deep at every azimuth"
"""Why there is no image where all presses reached their depth."""
_TURNS = np.linspace(0.0, np.pi / 2, 181)
"""Azimuths in rad among which the highest and the lowest first touch are looked for."""
_LEVELS = 2
"""Levels an image step."""


@dataclass(frozen=True, eq=False)
class TwoMirrorSeries:
    """One quantity of all presses at every level, ready to be asked at any pose.

    Attributes
    ----------
    skin
        The skin.
    levels_mm
        (l,) levels, evenly spaced.
    levels
        Runs of tilts at each level, whose splines give the shares (t,) of the solved tilts.
    values
        (l, t, n, …) the quantity at the azimuths 0, 360°/n, …; 0 where a press did not come to the level.
    """

    skin: Skin
    levels_mm: FloatArray
    levels: TiltRuns
    values: FloatArray

    def at(self, tilt_deg: FloatArray, azimuth: FloatArray, depth_mm: float) -> FloatArray:
        """The quantity (p, …) at tilts (p,) in degrees and azimuths (p,) in rad, at one depth in mm from first touch.

        At first touch it is 0, and so counts a part that no run covers; see `TwoMirrorTable.label`.
        """
        deep = depth_mm - first_touch(self.skin, tilt_deg, azimuth)
        first, shares = _between_levels(deep, self.levels_mm)
        found = np.zeros((len(tilt_deg), *self.values.shape[3:]))
        if depth_mm == 0:
            return found
        for level, values in enumerate(self.values):
            inside = (level >= first) & (level < first + _CUBIC)
            share = np.where(inside, shares[np.arange(len(deep)), np.clip(level - first, 0, _CUBIC - 1)], 0.0)
            used = np.flatnonzero(share)
            for chosen, tilts in self.levels.read(tilt_deg[used], level):
                here = used[chosen]
                around = share[here, None] * between_azimuths(azimuth[here], values.shape[1])
                found[here] += np.tensordot(tilts[:, :, None] * around[:, None, :], values, axes=2)
        return found


@dataclass(frozen=True, eq=False)
class TwoMirrorTable:
    """Presses of one skin with two mirrors under walls, by tilt and azimuth.

    Attributes
    ----------
    rows
        (t, a) presses by rising tilt, each row by rising azimuth of 0 to 90°; the straight press at all of them.
    azimuths_deg, tilts_deg
        (a,) and (t,) degrees.
    depths_mm
        (d,) depths of the images after rest, of the deepest column.
    touch_mm
        (t, k) how much higher walls of each tilt touch first than the straight one, at azimuths around.
    """

    rows: tuple[tuple[Press, ...], ...]
    azimuths_deg: tuple[float, ...]
    tilts_deg: FloatArray
    depths_mm: FloatArray
    touch_mm: FloatArray

    @classmethod
    def of(cls, presses: Sequence[Press]) -> TwoMirrorTable:
        """Arrange presses.

        Raises
        ------
        PalpateError
            If the obstacle does not tilt, the azimuths are not 0 to 90° in equal steps, or a press is missing.
        """
        table, azimuths = sort_presses(presses)
        tilts, skin = np.array(sorted({tilt for tilt, _ in table})), presses[0].mesh.skin
        rows = tuple(tuple(table[tilt, azimuth] for azimuth in azimuths) for tilt in tilts)
        depths = max((shared_depths(column) for column in zip(*rows, strict=True)), key=len)
        touch = np.array([first_touch(skin, np.full(len(_TURNS), tilt), _TURNS) for tilt in tilts])
        return cls(rows, azimuths, tilts, depths, touch)

    @property
    def levels_mm(self) -> FloatArray:
        """(l,) levels at which presses are interpolated."""
        step = self.depths_mm[0] / _LEVELS
        return np.asarray(step * np.arange(-np.ceil(self.touch_mm.max() / step), _LEVELS * len(self.depths_mm) + 1))

    @property
    def known(self) -> BoolArray:
        """(l, t) whether all presses of a tilt came down to a level."""
        reached = [[float(press.depth.max()) for press in row] for row in self.rows]
        late = np.array([self._late(row) for row in self.rows])
        return np.asarray((self.levels_mm[:, None, None] + late <= np.array(reached) + SAME_DEPTH_MM).all(axis=2))

    def series(self, follow: Callable[[Press], FloatArray]) -> TwoMirrorSeries:
        """A quantity at all levels; `follow` gives it at the images of a press and its mirror images, (i, 4, …)."""
        values = np.stack([self._around(row, follow) for row in self.rows], axis=1)
        known, count = self.known, len(self.tilts_deg)
        shares = np.broadcast_to(np.eye(count), (len(known), count, count))
        runs = cut_into_runs(self.tilts_deg, np.where(known, "known", ""), [""] * count, shares, None)
        return TwoMirrorSeries(self.rows[0][0].mesh.skin, self.levels_mm, runs, np.nan_to_num(values))

    def label(self, images_mm: FloatArray) -> TiltRuns:
        """Runs of tilts at depths (d,) mm, of presses that share a branch and came deep enough, without values.

        At first touch all are known.
        """
        levels, before = self.levels_mm, np.concatenate([self.touch_mm[:1], self.touch_mm[:-1]]).min(axis=1)
        needed = np.ceil((images_mm[:, None] - before - SAME_DEPTH_MM - levels[0]) / (levels[1] - levels[0]))
        labels = np.array([label_presses(column, images_mm) for column in zip(*self.rows, strict=True)])
        reached = (needed < self.known.sum(axis=0)) | (images_mm[:, None] == 0)
        branch = np.where(reached & (labels == labels[0]).all(axis=0), labels[0], "")
        first = [min(row, key=lambda press: press.ended_depth) for row in self.rows]
        ended = [_NOT_SO_DEEP if press.ended is EndReason.DEPTH_REACHED else str(press.ended) for press in first]
        return cut_into_runs(self.tilts_deg, branch, ended, np.zeros((*branch.shape, 1)), None)

    def _late(self, row: Sequence[Press]) -> FloatArray:
        """(a,) mm by which the presses of one tilt touch higher than the straight one."""
        return first_touch(row[0].mesh.skin, np.full(len(row), row[0].obstacle.radial), np.radians(self.azimuths_deg))

    def _around(self, row: Sequence[Press], follow: Callable[[Press], FloatArray]) -> FloatArray:
        """A quantity (l, n, …) of the presses of one tilt at all levels and azimuths."""
        late = zip(row, self._late(row), strict=True)
        return all_azimuths([at_depths(press, follow(press), self.levels_mm + by) for press, by in late])


def first_touch(skin: Skin, tilt_deg: FloatArray, azimuth: FloatArray) -> FloatArray:
    """Z - Z(0) (n,) mm of tilts (n,) in degrees at azimuths (n,) in rad."""
    turns = rotation_vector(np.radians(tilt_deg), azimuth)
    normals = np.array([wall_normal(*turn) for turn in turns.tolist()]).reshape(-1, 3)
    return skin.support_height(normals) - skin.outer_height


def between_azimuths(azimuth: FloatArray, count: int) -> FloatArray:
    """Shares (n, count) that evenly spaced azimuths, an even number of them from 0, have in azimuths (n,) in rad.

    Those of the trigonometric polynomial through them: ``(1 + 2 Σ cos k x + cos (count x / 2)) / count`` with x from
    one to the other, and k below half their number.
    """
    apart = azimuth[:, None] - 2 * np.pi * np.arange(count) / count
    waves = 2.0 * np.cos(np.arange(1, count // 2) * apart[..., None]).sum(axis=-1)
    return np.asarray((1.0 + waves + np.cos(count // 2 * apart)) / count)


def _between_levels(deep: FloatArray, levels: FloatArray) -> tuple[IntArray, FloatArray]:
    """Number of the first of four levels (n,), and their shares (n, 4), in places (n,) mm among them: Lagrange's."""
    place = (deep - levels[0]) / (levels[1] - levels[0])
    first = np.clip(np.ceil(place - 1e-9).astype(int) - _CUBIC + 1, 0, max(len(levels) - _CUBIC, 0))
    at = place - first
    others = [[k for k in range(_CUBIC) if k != own] for own in range(_CUBIC)]
    shares = [np.prod([(at - k) / (own - k) for k in others[own]], axis=0) for own in range(_CUBIC)]
    return first, np.column_stack(shares)
