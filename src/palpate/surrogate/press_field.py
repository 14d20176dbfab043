"""Presses of one skin interpolated to any pose of the obstacle: markers, force and whole surface.

One type serves skins of revolution (`palpate.surrogate.revolved_field`) and skins with two mirrors
(`palpate.surrogate.two_mirror_field`); datasets, error bounds and the viewer read it.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Protocol, Self

import numpy as np
from scipy.spatial import cKDTree

from palpate.core import FloatArray, IntArray, PalpateError, TextArray
from palpate.design import MarkerLayout, PoseSpace
from palpate.fea import Press
from palpate.mesh import Mesh
from palpate.surrogate.tilt_runs import TiltRuns

NodalRead = Callable[[Press, Mesh], FloatArray]
"""Reads a nodal field (i, n, c) of a press on another mesh of its skin; a vector if c = 3."""
_SAME_MM = 1e-6
"""Maximum distance of a node from the mirror image of another."""


class Series(Protocol):
    """One quantity of all presses."""

    def at(self, tilt_deg: FloatArray, azimuth: FloatArray, depth_index: int) -> FloatArray:
        """Values (n, …) at tilts (n,) in degrees, azimuths (n,) in rad and a depth; NaN if not known."""
        ...


@dataclass(frozen=True, eq=False)
class PressField(ABC):
    """Presses of one skin over the disc of tilts, at common depths.

    Attributes
    ----------
    presses
        They differ by the pose of the obstacle alone.
    depths_mm
        (d,) depths.
    runs
        Runs of tilts at each depth.
    rest
        (m, 3) mm, undeformed markers.
    """

    presses: tuple[Press, ...]
    depths_mm: FloatArray
    runs: TiltRuns
    rest: FloatArray

    @property
    def space(self) -> PoseSpace:
        """Components of the presses' poses."""
        return self.presses[0].obstacle.pose_space

    @property
    def max_offset(self) -> float | None:
        """Maximum offset that was pressed, mm, or tilt of walls at the side; `None` for others.

        Their maximum tilt is in a dataset's spec.
        """
        return None if self.space.is_tilt and not self.space.is_side else float(self.runs.tilts_deg[-1])

    @property
    def min_tilt_deg(self) -> float:
        """Minimum tilt of walls at the side, degrees; 0 if poses include the straight one."""
        return float(self.runs.tilts_deg[0]) if self.space.is_side else 0.0

    def labels(self, tilt_deg: FloatArray, depth_index: int) -> tuple[TextArray, TextArray]:
        """Branch of each tilt (n,) at one depth, or the reason for its absence; see `TiltRuns.labels`."""
        return self.runs.labels(tilt_deg, depth_index)

    def with_markers(self, markers: MarkerLayout) -> Self:
        """The field with the markers of a layout.

        Raises
        ------
        PalpateError
            If a marker is not on the skin.
        """
        outside = int((~np.isfinite(markers.positions).all(axis=1)).sum())
        if outside:
            raise PalpateError(
                f"{outside} markers lie outside the dome.",
                "Leave them out, or use smaller rings.",
                code="markers-outside-skin",
            )
        found = replace(self, rest=np.asarray(markers.positions, dtype=float))
        found.moved  # noqa: B018 - a marker that is not on the skin raises here
        return found

    def positions(self, rx_deg: FloatArray, ry_deg: FloatArray, depth_index: int) -> FloatArray:
        """Deformed positions of the markers.

        Parameters
        ----------
        rx_deg, ry_deg
            (n,) components of the wall's rotation; of another obstacle, its x and y in mm.
        depth_index
            Number of the depth in `depths_mm`.

        Returns
        -------
        FloatArray
            (n, m, 3) mm; NaN for a pose that no run covers (`labels` gives the reason).
        """
        return self.rest + self.moved.at(np.hypot(rx_deg, ry_deg), np.arctan2(ry_deg, rx_deg), depth_index)

    def forces(self, rx_deg: FloatArray, ry_deg: FloatArray, depth_index: int) -> FloatArray:
        """Force (n, 3) N of the skin on the wall, skin's frame; arguments as for `positions`, NaN as there."""
        return self.force.at(np.hypot(rx_deg, ry_deg), np.arctan2(ry_deg, rx_deg), depth_index)

    @cached_property
    @abstractmethod
    def moved(self) -> Series:
        """Displacement (n, m, 3) mm of the markers."""

    @cached_property
    @abstractmethod
    def force(self) -> Series:
        """Force (n, 3) N on a wall, skin's frame."""

    @abstractmethod
    def nodal(self, mesh: Mesh, read: NodalRead, *, linear: bool) -> Series:
        """Interpolate a field (n, nodes, c) of the nodes of the skin, which are the first of a mesh.

        Of a skin of revolution on a half mesh in the frame of the tilt, whatever the azimuth; of a skin with two
        mirrors on a whole mesh in its own frame.

        Raises
        ------
        PalpateError
            If the mesh lacks the mirrors of its skin.
        """


def surface_displacement(press: Press, mesh: Mesh) -> FloatArray:
    """Displacement (i, n, 3) mm of a press at the nodes of another mesh of its skin."""
    return press.interpolated_to(mesh).displacement


def wall_nodes(mesh: Mesh) -> FloatArray:
    """Nodes (n, 3) mm of a skin, undeformed, without those of a gel inside."""
    return mesh.nodes[: len(mesh.inner_disc)]


def find_nodes(nodes: FloatArray, places: FloatArray) -> IntArray:
    """Numbers (m,) of the nodes, of (n, 3) mm, at places (m, 3) mm.

    Raises
    ------
    PalpateError
        If a place has no node: the mesh lacks the mirrors of its skin.
    """
    distance, found = cKDTree(nodes).query(places)
    if distance.max() > _SAME_MM:
        raise PalpateError(
            f"The mesh is not symmetric: a mirror image of a node lies {distance.max():.2g} mm from the nearest one.",
            "Solve the presses again with this version.",
            code="mesh-not-symmetric",
        )
    return np.asarray(found)
