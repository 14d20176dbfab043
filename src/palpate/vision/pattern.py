"""The pattern of a layout as a camera sees it at rest, and the turns and mirrors that leave it as it is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from palpate.core import BoolArray, FloatArray
from palpate.vision.rings import Rings, find_rings

_SAME = 1e-6
"""Distance over the layout's size at which two markers are at one place."""


@dataclass(frozen=True, eq=False)
class MarkerPattern:
    """Where markers are expected at rest.

    Attributes
    ----------
    expected_px
        (m, 2) pixels for the nominal camera.
    symmetries
        (g, m) for each turn or mirror about the axis that leaves the layout as it is, which marker comes to lie at
        the place of marker i; the first is none at all.
    turns_deg, mirrored
        (g,) angle of the turn, and whether the layout was mirrored in its x-z plane before.
    marks_px
        (g, 2) where the orientation mark is then expected; `None` without a mark.
    rings
        The rings of a layout that turns and mirrors about each of their dots leave as it is; `None` for others.
    mark
        (3,) the orientation mark, mm; `None` without a mark.
    """

    expected_px: FloatArray
    symmetries: NDArray[np.intp]
    turns_deg: FloatArray
    mirrored: BoolArray
    marks_px: FloatArray | None
    rings: Rings | None = None
    mark: FloatArray | None = None

    def __len__(self) -> int:
        return len(self.expected_px)

    @property
    def spacing_px(self) -> float:
        """Least distance of two markers."""
        return float(cKDTree(self.expected_px).query(self.expected_px, 2)[0][:, 1].min())

    @property
    def widest_gap(self) -> float:
        """Longest step on the shortest way through all markers, over the median distance of nearest neighbours."""
        from scipy.sparse.csgraph import minimum_spanning_tree

        if len(self) < 2:
            return 0.0
        away = np.linalg.norm(self.expected_px[:, None] - self.expected_px, axis=-1)
        steps: FloatArray = minimum_spanning_tree(away).data
        return float(steps.max() / np.median(np.sort(away, axis=1)[:, 1]))


@dataclass(frozen=True, eq=False)
class PatternFit:
    """Which dot is at which place of the pattern.

    Attributes
    ----------
    blob
        (m,) dot at each marker's place, -1 where there is none.
    places_px
        (m, 2) where the print's own law expects each dot.
    residual_px
        Root of the mean squared distance of the dots from there.
    mirrored
        Whether the pattern was laid in its mirror.
    marks_px, mark_axes_px
        (g, 2) where the orientation mark would be under each symmetry, and (g, 2, 2) two axes about it as long as its
        standard deviations along them; `None` without a mark.
    doubt
        What speaks against it, as a part of a sentence; empty where nothing does.
    """

    blob: NDArray[np.intp]
    places_px: FloatArray
    residual_px: float
    mirrored: bool
    marks_px: FloatArray | None
    mark_axes_px: FloatArray | None
    doubt: str = ""

    @property
    def count(self) -> int:
        """Number of markers that have a dot."""
        return int((self.blob >= 0).sum())


def build_pattern(
    positions: FloatArray, project: Callable[[FloatArray], FloatArray], mark: FloatArray | None = None
) -> MarkerPattern:
    """The pattern of a layout.

    Parameters
    ----------
    positions
        (m, 3) markers in the dome's frame, mm.
    project
        From points (n, 3) to pixels (n, 2): that of the nominal camera.
    mark
        (3,) the orientation mark, mm (`palpate.design.place_orientation_mark`).
    """
    motions = [(turn, mirror) for mirror in (False, True) for turn in _candidate_turns(positions, mirror)]
    found = [(motion, order) for motion in motions if (order := _order(positions, *motion)) is not None]
    marks = None if mark is None else project(np.stack([_move(mark, *motion) for motion, _ in found]))
    rings = find_rings(positions)
    if rings is not None and len(found) != 2 * len(rings.members(1)):
        rings = None
    return MarkerPattern(
        expected_px=project(positions),
        symmetries=np.stack([order for _, order in found]),
        turns_deg=np.degrees([motion[0] for motion, _ in found]),
        mirrored=np.array([motion[1] for motion, _ in found]),
        marks_px=marks,
        rings=rings,
        mark=mark,
    )


def _move(points: FloatArray, turn: float, mirror: bool) -> FloatArray:
    x, y, z = np.moveaxis(np.asarray(points, float), -1, 0)
    y = -y if mirror else y
    return np.stack([np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y, z], axis=-1)


def _candidate_turns(positions: FloatArray, mirror: bool) -> list[float]:
    """Turns that bring the first of the outermost markers to the place of another; no turn comes first."""
    rho = np.hypot(positions[:, 0], positions[:, 1])
    outermost = int(np.argmax(rho))
    if rho[outermost] == 0.0:
        return [0.0]
    angle = np.arctan2(positions[:, 1], positions[:, 0])
    start = -angle[outermost] if mirror else angle[outermost]
    turns = (angle[np.abs(rho - rho[outermost]) < _SAME * rho[outermost]] - start) % (2.0 * np.pi)
    return sorted(float(turn) if turn < 2.0 * np.pi - _SAME else 0.0 for turn in turns)


def _order(positions: FloatArray, turn: float, mirror: bool) -> NDArray[np.intp] | None:
    distance, place = cKDTree(positions).query(_move(positions, turn, mirror))
    if distance.max() > 10.0 * _SAME * np.abs(positions).max() or len(set(place)) != len(positions):
        return None
    order = np.empty(len(positions), np.intp)
    order[place] = np.arange(len(positions))
    return order
