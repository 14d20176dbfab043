"""A pressed skin for any pose of the wall: what every interpolation of its solved presses answers.

Only the wall of the skin is drawn, so fields are of its nodes, which are a mesh's first; a gel inside is left out.
Markers are those of the dataset: `build_field` at the same depths.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from palpate.core import FloatArray, IntArray, PalpateError
from palpate.design import MarkerLayout, rotation_vector
from palpate.fea import ObstacleSpec, Press, nodal_von_mises
from palpate.mesh import Mesh, locate_nodes
from palpate.twin import MarkerField, TiltRuns, build_field

Array32 = NDArray[np.float32]
SAME_MM, _SAME_DEG = 1e-6, 1e-9


@dataclass(frozen=True, eq=False)
class SurfaceMotion:
    """One press at one pose of the wall, from first touch as deep as it is known.

    Attributes
    ----------
    tilt_deg, azimuth_deg
        Of the wall; the azimuth is 0 where one motion is turned to all of them.
    depths_mm
        (k,) depths, from 0.
    displacement
        (k, n, 3) mm of the nodes of the skin's wall.
    force_n
        (k,) norm of the wall's force.
    branch
        (k,) label of each depth.
    ended
        Why it goes no deeper.
    normal, touch, way
        The wall's outward unit normal (3,), the point (3,) mm that it touches first, and the unit vector (3,) against
        which it comes.
    """

    tilt_deg: float
    azimuth_deg: float
    depths_mm: FloatArray
    displacement: Array32
    force_n: FloatArray
    branch: tuple[str, ...]
    ended: str
    normal: FloatArray
    touch: FloatArray
    way: FloatArray


@dataclass(frozen=True, eq=False)
class PressedSkin(ABC):
    """Presses of one skin that differ by the pose of the wall alone.

    Attributes
    ----------
    mesh
        What they are drawn on: of a press each has its pole elsewhere.
    obstacle
        What pressed, at any pose.
    presses
        All of them; none of a skin at rest.
    depths_mm
        (d,) depths, from 0.
    runs
        Runs of tilts at each depth.
    """

    mesh: Mesh
    obstacle: ObstacleSpec
    presses: tuple[Press, ...]
    depths_mm: FloatArray
    runs: TiltRuns
    _fields: dict[bytes, MarkerField] = field(default_factory=dict, kw_only=True)

    turned: ClassVar[bool]
    """Whether one motion, turned about the axis, serves every azimuth; fields are then of a half mesh."""

    @property
    def tilts_deg(self) -> FloatArray:
        """(t,) solved tilts, rising."""
        return self.runs.tilts_deg

    @cached_property
    def nodes(self) -> FloatArray:
        """(n, 3) mm nodes of the skin's wall at rest."""
        return self.mesh.nodes[: len(self.mesh.inner_disc)]

    def at(self, tilt_deg: float, azimuth_deg: float = 0.0) -> SurfaceMotion:
        """The press at a tilt (degrees) between the least and the greatest that were solved, and at an azimuth.

        Raises
        ------
        PalpateError
            If the tilt is not finite or beyond them, or the azimuth is no angle.
        """
        first, last = float(self.tilts_deg[0]), float(self.tilts_deg[-1])
        if not first - _SAME_DEG <= tilt_deg <= last + _SAME_DEG:
            raise PalpateError(
                f"{tilt_deg:g}° was not pressed.",
                f"Choose a tilt from {first:g} to {last:g}°.",
                code="tilt-not-pressed",
            )
        azimuth = 0.0 if self.turned else _finite(azimuth_deg)
        labels = [self.runs.labels(np.array([tilt_deg]), image) for image in range(len(self.depths_mm))]
        deep = next((k for k, (branch, _) in enumerate(labels) if branch[0] == ""), len(labels))
        displacement, force = self.fields(tilt_deg, azimuth, deep)
        wall = self.obstacle.model_copy(
            update={"tilt_deg": float(np.clip(tilt_deg, first, last)), "azimuth_deg": azimuth}
        )
        obstacle, touch = wall.at_first_contact(self.mesh)
        return SurfaceMotion(
            tilt_deg=float(tilt_deg),
            azimuth_deg=azimuth,
            depths_mm=self.depths_mm[:deep],
            displacement=displacement,
            force_n=np.maximum(force, 0.0),
            branch=tuple(str(branch[0]) for branch, _ in labels[:deep]),
            ended=str(labels[deep][1][0]) if deep < len(labels) else self._end(tilt_deg),
            normal=obstacle.gap(touch[None]).normal[0],
            touch=touch,
            way=wall.approach_axis(self.mesh),
        )

    @abstractmethod
    def fields(self, tilt_deg: float, azimuth_deg: float, deep: int) -> tuple[Array32, FloatArray]:
        """Displacement (k, n, 3) mm of the nodes and force (k,) N at the first `deep` depths."""

    @abstractmethod
    def stress(self, motion: SurfaceMotion) -> Array32:
        """Von Mises stress (k, n) in MPa for a motion, interpolated like the displacement."""

    def markers(self, layout: MarkerLayout, motion: SurfaceMotion, azimuth_deg: float) -> FloatArray:
        """Deformed positions (k, m, 3) mm of a layout's markers, skin's frame, at every depth of a motion.

        Parameters
        ----------
        layout
            Undeformed markers (m, 3) mm.
        motion
            A press of this skin.
        azimuth_deg
            Direction of the wall's rotation axis.

        Raises
        ------
        PalpateError
            If the azimuth is not finite, or a marker is not on the skin.
        """
        azimuth = np.radians([_finite(azimuth_deg)])
        if not self.presses:
            return np.broadcast_to(layout.positions, (len(motion.depths_mm), *layout.positions.shape))
        name = layout.positions.tobytes()
        if name not in self._fields:
            self._fields[name] = build_field(self.presses, layout, self.depths_mm)
        rx, ry = rotation_vector(motion.tilt_deg, azimuth).T
        return np.concatenate([self._fields[name].positions(rx, ry, k) for k in range(len(motion.depths_mm))])

    def _end(self, tilt_deg: float) -> str:
        """Why the presses next to a tilt go no deeper: the reason of the one that ended first."""
        known = (self.runs.branch != "").sum(axis=0)
        return self.runs.ended[min(self.runs.neighbours(tilt_deg), key=lambda number: known[number])]


def find_nodes(nodes: FloatArray, places: FloatArray) -> IntArray:
    """Numbers (m,) of the nodes, of (n, 3) mm, at places (m, 3) mm.

    Raises
    ------
    PalpateError
        If there is no node at one: the mesh has not the mirrors of its skin.
    """
    distance, found = cKDTree(nodes).query(places)
    if distance.max() > SAME_MM:
        raise PalpateError(
            f"The mesh is not symmetric: a mirror image of a node lies {distance.max():.2g} mm from the nearest one.",
            "Solve the presses again with this version.",
            code="mesh-not-symmetric",
        )
    return np.asarray(found)


def nodal_stress_on(press: Press, mesh: Mesh) -> FloatArray:
    """Von Mises stress (i, n, 1) in MPa of a press at the nodes of another mesh of its skin's wall; 0 at rest."""
    stress = np.nan_to_num(nodal_von_mises(press))[..., None]
    return locate_nodes(press.mesh, mesh).interpolate(stress)


def _finite(azimuth_deg: float) -> float:
    if not np.isfinite(azimuth_deg):
        raise PalpateError(f"The azimuth {azimuth_deg} is no angle.", "Give degrees.", code="azimuth-not-finite")
    return float(azimuth_deg)
