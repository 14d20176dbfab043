"""Markers of a skin with the mirrors x → −x and y → −y for any tilt of a wall, from presses at several azimuths.

No turn but half a one leaves such a skin as it is, so every tilt is pressed at azimuths from 0 to 90° in equal steps.
The mirrors give the others (`palpate.twin.turned_presses`). Between tilts every azimuth has a cubic spline (see
`tilt_runs`); it ends at the straight press, for a wall that tilts the other way touches a flat pad at its other side,
which is a kink. Between the n azimuths the markers are the trigonometric polynomial through them

    u(t, α) = Re Σ_k c_k(t) exp(i k α),      k = 0 … n/2 .

What is smooth over tilts and azimuths is where the wall is, not how far it has come since first touch: a wall that
turns away from a side of a pad leaves it for a corner at once. With Z(t, α) the height at which a wall that first
touches crosses the axis, presses are therefore interpolated at one height of the wall over the axis, the *level*

    l = d - Z(t, α) + Z(0)

of the depth d, below 0 where the wall is not yet down to the top. A press is at level l by the cubic spline through
its images; between levels, half an image step apart, the markers are the cubic through four of them. So images end
short of the presses: at tilts up to t by as much as the presses at t touch higher than those at the tilt before.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray, TextArray
from palpate.design import MarkerLayout, Skin, rotation_vector, wall_normal
from palpate.fea import Press
from palpate.mechanics import Ended
from palpate.twin.marker_field import MarkerField
from palpate.twin.tilt_runs import SAME_DEPTH_MM, TiltRuns, cut_into_runs, label_presses, shared_depths
from palpate.twin.turned_presses import all_azimuths, follow_levels, sort_presses

_CUBIC = 4
"""Levels between which one is interpolated."""
_NOT_SO_DEEP = "not pressed so deep at every azimuth"
"""Why there is no image where all presses reached their depth."""
_TURNS = np.linspace(0.0, np.pi / 2, 181)
"""Azimuths in rad among which the highest and the lowest first touch are looked for."""
_LEVELS = 2
"""Levels an image step."""


@final
@dataclass(frozen=True)
class TurnedField(MarkerField):
    """Markers of a skin with two mirrors.

    Attributes
    ----------
    skin
        The skin.
    levels_mm
        (l,) levels, evenly spaced.
    levels
        Runs of tilts at each level, whose splines give displacements (n, m, 3) in mm at the azimuths 0, 360°/n, … .
    """

    skin: Skin
    levels_mm: FloatArray
    levels: TiltRuns

    def positions(self, rx_deg: FloatArray, ry_deg: FloatArray, image: int) -> FloatArray:
        tilt, azimuth = np.hypot(rx_deg, ry_deg), np.arctan2(ry_deg, rx_deg)
        deep = self.depths_mm[image] - first_touch(self.skin, tilt, azimuth)
        first, shares = _between_levels(deep, self.levels_mm)
        moved = np.where(self.labels(tilt, image)[0] == "", np.nan, 0.0)[:, None, None] + np.zeros(self.rest.shape)
        for level in range(len(self.levels_mm)):
            inside = (level >= first) & (level < first + _CUBIC)
            share = np.where(inside, shares[np.arange(len(tilt)), np.clip(level - first, 0, _CUBIC - 1)], 0.0)
            used = np.flatnonzero(share)
            for chosen, values in self.levels.read(tilt[used], level):
                waves = share[used[chosen], None] * between_azimuths(azimuth[used[chosen]], values.shape[1])
                moved[used[chosen]] += np.einsum("nk,nkmi->nmi", waves, values)
        return np.asarray(self.rest + moved)


def build_turned_field(
    presses: Sequence[Press], markers: MarkerLayout, depths_mm: FloatArray | None = None
) -> TurnedField:
    """Interpolate presses of a skin with two mirrors under walls; see `palpate.twin.build_field`.

    Raises
    ------
    PalpateError
        If the obstacle does not tilt, the azimuths are not 0 to 90° in equal steps, or a press is missing.
    """
    table, azimuths = sort_presses(presses)
    tilts, skin = np.array(sorted({tilt for tilt, _ in table})), presses[0].mesh.skin
    rows = [[table[tilt, azimuth] for azimuth in azimuths] for tilt in tilts]
    depths = max((shared_depths(column) for column in zip(*rows, strict=True)), key=len)
    images = depths if depths_mm is None else depths_mm
    touch = np.array([first_touch(skin, np.full(len(_TURNS), tilt), _TURNS) for tilt in tilts])
    step = depths[0] / _LEVELS
    levels = step * np.arange(-np.ceil(touch.max() / step), _LEVELS * len(depths) + 1)
    values = np.stack([_around(row, azimuths, markers, levels) for row in rows], axis=1)
    known = np.isfinite(values).all(axis=(2, 3, 4))
    before = np.concatenate([touch[:1], touch[:-1]]).min(axis=1)
    needed = np.ceil((images[:, None] - before - SAME_DEPTH_MM - levels[0]) / step)
    branch, ended = _label(rows, images, needed < known.sum(axis=0))
    nothing = np.zeros((*branch.shape, 1))
    return TurnedField(
        rest=np.asarray(markers.positions, dtype=float),
        depths_mm=images,
        runs=cut_into_runs(tilts, branch, ended, nothing, None),
        space=presses[0].wall.pose_space,
        skin=skin,
        levels_mm=levels,
        levels=cut_into_runs(tilts, np.where(known, "known", ""), ended, values, None),
    )


def _label(rows: Sequence[Sequence[Press]], images: FloatArray, reached: BoolArray) -> tuple[TextArray, list[str]]:
    """Branch (d, t) that the presses of each tilt share, where levels are reached, and why each tilt ended."""
    labels = np.array([label_presses(column, images) for column in zip(*rows, strict=True)])
    branch = np.where(reached & (labels == labels[0]).all(axis=0), labels[0], "")
    first = [min(row, key=lambda press: press.ended_depth) for row in rows]
    ended = [_NOT_SO_DEEP if press.ended is Ended.DEPTH_REACHED else str(press.ended) for press in first]
    return branch, ended


def first_touch(skin: Skin, tilt_deg: FloatArray, azimuth: FloatArray) -> FloatArray:
    """Z - Z(0) (n,) mm of tilts (n,) in degrees at azimuths (n,) in rad."""
    turns = rotation_vector(np.radians(tilt_deg), azimuth)
    normals = np.array([wall_normal(*turn) for turn in turns.tolist()]).reshape(-1, 3)
    return skin.touch_height(normals) - skin.outer_height


def between_azimuths(azimuth: FloatArray, count: int) -> FloatArray:
    """Shares (n, count) that evenly spaced azimuths, an even number of them from 0, have in azimuths (n,) in rad.

    Those of the trigonometric polynomial through them: ``(1 + 2 Σ cos k x + cos (count x / 2)) / count`` with x from
    one to the other, and k below half their number.
    """
    apart = azimuth[:, None] - 2 * np.pi * np.arange(count) / count
    waves = 2.0 * np.cos(np.arange(1, count // 2) * apart[..., None]).sum(axis=-1)
    return np.asarray((1.0 + waves + np.cos(count // 2 * apart)) / count)


def _around(row: Sequence[Press], azimuths: Sequence[float], markers: MarkerLayout, levels: FloatArray) -> FloatArray:
    """Displacements (l, n, m, 3) mm at all azimuths and levels (l,) mm of one tilt's presses, by rising azimuth."""
    late = first_touch(row[0].mesh.skin, np.full(len(row), row[0].wall.radial), np.radians(azimuths))
    pairs = zip(row, late, strict=True)
    return all_azimuths([follow_levels(press, markers.positions, levels + by) for press, by in pairs])


def _between_levels(deep: FloatArray, levels: FloatArray) -> tuple[IntArray, FloatArray]:
    """Number of the first of four levels (n,), and their shares (n, 4), in places (n,) mm among them: Lagrange's."""
    place = (deep - levels[0]) / (levels[1] - levels[0])
    first = np.clip(np.ceil(place - 1e-9).astype(int) - _CUBIC + 1, 0, max(len(levels) - _CUBIC, 0))
    at = place - first
    others = [[k for k in range(_CUBIC) if k != own] for own in range(_CUBIC)]
    shares = [np.prod([(at - k) / (own - k) for k in others[own]], axis=0) for own in range(_CUBIC)]
    return first, np.column_stack(shares)
