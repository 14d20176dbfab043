"""Marker pattern in the camera's image at rest, and its rotations and mirror symmetries."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from palpate.core import BoolArray, FloatArray
from palpate.vision.rings import Rings, find_rings

Angle = TypeVar("Angle", float, FloatArray)
_SAME = 1e-6
"""Maximum distance of coincident markers, over the layout's size."""


@dataclass(frozen=True, eq=False)
class MarkerPattern:
    """Expected markers at rest.

    Attributes
    ----------
    expected_px
        (m, 2) pixels for the nominal camera.
    symmetries
        (g, m) for each rotation or mirroring about the axis that preserves the layout, the marker that moves to the
        place of marker i; the first is the identity.
    turns_deg, mirrored
        (g,) angle of the rotation, and whether the layout was mirrored in its x-z plane before.
    marks_px
        (g, 2) expected orientation mark; `None` without a mark.
    rings
        Rings of a layout with the symmetry of its innermost ring; `None` for other layouts.
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
        """Minimum distance of two markers."""
        return float(cKDTree(self.expected_px).query(self.expected_px, 2)[0][:, 1].min())

    @property
    def widest_gap(self) -> float:
        """Longest edge of the minimum spanning tree, over the median distance of nearest neighbours."""
        from scipy.sparse.csgraph import minimum_spanning_tree

        if len(self) < 2:
            return 0.0
        away = np.linalg.norm(self.expected_px[:, None] - self.expected_px, axis=-1)
        steps: FloatArray = minimum_spanning_tree(away).data
        return float(steps.max() / np.median(np.sort(away, axis=1)[:, 1]))


@dataclass(frozen=True, eq=False)
class PatternFit:
    """Fit of the pattern to blobs.

    Attributes
    ----------
    blob, places_px
        (m,) blob at each marker's place, -1 without one, and (m, 2) its position by the fitted print.
    residual_px
        Root mean square distance of the blobs from these.
    mirrored
        Whether the pattern was mirrored.
    marks_px, mark_axes_px
        (g, 2) predicted orientation mark under each symmetry, and (g, 2, 2) axes scaled to its standard deviations;
        `None` without a mark.
    doubt
        Reason to doubt the fit, as a part of a sentence; empty without one.
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
        """Number of markers with a blob."""
        return int((self.blob >= 0).sum())


def build_pattern(
    positions: FloatArray, project: Callable[[FloatArray], FloatArray], mark: FloatArray | None = None
) -> MarkerPattern:
    """Build the pattern of markers (m, 3) mm and an orientation mark (3,) mm in the nominal camera.

    `project` maps points (n, 3) to pixels (n, 2); for the mark see `palpate.design.place_orientation_mark`.
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


def wrap_deg(angle_deg: Angle) -> Angle:
    """Return angles in degrees within ±180°."""
    return (angle_deg + 180.0) % 360.0 - 180.0


def _candidate_turns(positions: FloatArray, mirror: bool) -> list[float]:
    """Return the angles that rotate one outermost marker to the place of another, ascending from 0."""
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
