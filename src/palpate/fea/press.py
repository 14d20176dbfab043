"""A press: one simulated contact from first touch to full depth."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, IntArray, TextArray
from palpate.fea.spec import SolverSpec, WallSpec
from palpate.material import Material
from palpate.mesh import Mesh, locate_inner

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FEA_VERSION = "7"
"""Version of everything in mesh, material and fea that changes a press's numbers; part of artefact keys."""


class Ended(StrEnum):
    """Why a press ended."""

    DEPTH_REACHED = "depth reached"
    WALL_AT_CLAMP = "wall reached the clamped rim"
    BRANCH_ENDED = "the branch ended"
    NO_BRANCH = "no inverted state"
    FOLDED = "the squeezed silicone folded"
    NOT_CONVERGED = "not converged"


class Branch(StrEnum):
    """Which of the two stable states an image shows."""

    FLAT = "flat"
    INVERTED = "inverted"


@dataclass(frozen=True)
class Press:
    """What a press left: one *image* at rest, one every image step, and the last state where it ended early.

    Attributes
    ----------
    mesh, material, wall, solver
        What made it.
    depth
        (n,) mm travel of the wall since first touch.
    displacement
        (n, n_nodes, 3) mm; of a half model in the frame whose y-z plane is the tilt plane, else in the dome's.
    force
        (n, 3) N of the whole dome on the wall, dome's frame.
    energy, contact_energy, dissipation, work
        (n,) mJ stored in the whole dome, in the contact penalty and sticking springs, lost to friction since rest,
        and done by the wall.
    branch
        (n,) `Branch` values.
    peak_stress
        (n,) MPa greatest von Mises Cauchy stress at a Gauss point.
    contact_area
        (n,) mm² deformed area that touches the wall, whole dome.
    apex_gap
        (n,) mm distance between the wall and the point that it touched first.
    hold_tension
        (n,) MPa greatest tension that held the flat patch to the wall (see `palpate.fea.hold`).
    negative_pivots
        (n,) unstable modes of the discrete equilibrium (0: stable; -1: the linear solver cannot tell).
    ended, ended_depth
        Reason of the end and the depth in mm at which it came.
    jump_depth
        Depth in mm at which the branch changed by a jump; nan where none did.
    cpu_s, unknowns, newton_iterations
        Cost.
    message
        One sentence with numbers where the end was not the full depth.
    """

    mesh: Mesh
    material: Material
    wall: WallSpec
    solver: SolverSpec
    depth: FloatArray
    displacement: FloatArray
    force: FloatArray
    energy: FloatArray
    contact_energy: FloatArray
    dissipation: FloatArray
    work: FloatArray
    branch: TextArray
    peak_stress: FloatArray
    contact_area: FloatArray
    apex_gap: FloatArray
    hold_tension: FloatArray
    negative_pivots: IntArray
    ended: Ended
    ended_depth: float
    jump_depth: float
    cpu_s: float
    unknowns: int
    newton_iterations: int
    message: str = ""

    def positions(self, points: FloatArray) -> FloatArray:
        """Follow points of the undeformed inner surface through every image.

        Parameters
        ----------
        points
            (m, 3) mm, dome's frame.

        Returns
        -------
        (n, m, 3) mm
            Deformed positions, dome's frame.
        """
        turn = np.eye(3) if self.mesh.spec.whole else azimuth_rotation(self.wall.azimuth_deg)
        points = np.asarray(points, float)
        local = points @ turn
        side = np.ones(3)
        mirrored = np.zeros(len(points), bool)
        if not self.mesh.spec.whole:
            mirrored = local[:, 0] < 0
            side = np.array([-1.0, 1.0, 1.0])
        seen = np.where(mirrored[:, None], local * side, local)
        moved = locate_inner(self.mesh, seen).interpolate(self.displacement)
        moved = np.where(mirrored[:, None], moved * side, moved)
        result: FloatArray = points + moved @ turn.T
        return result

    def von_mises(self) -> FloatArray:
        """Von Mises Cauchy stress (n, n_nodes) in MPa at the nodes, in every image.

        Raises
        ------
        PalpateError
            If CalculiX solved the press: its bricks have another pressure than our cells.
        """
        from palpate.fea.export import nodal_von_mises  # here, because an export knows presses

        return nodal_von_mises(self)

    def plot(self) -> Figure:
        """Draw the section as it is flattened, and the force over the depth."""
        from palpate.fea.plot_press import plot_press  # here, because pictures know results, and matplotlib is slow

        return plot_press(self)

    def picture(self, image: int = -1) -> NDArray[np.uint8]:
        """Picture (h, w, 3) of one image of the press in 3-D; needs the extra ``viz`` and OpenGL.

        Raises
        ------
        MissingExtraError
            If pyvista is not installed.
        PalpateError
            If this machine cannot draw in 3-D.
        """
        from palpate.fea.plot_press import picture_press

        return picture_press(self, image)

    def _repr_html_(self) -> str:
        from palpate.fea.plot_press import tabulate_press

        return tabulate_press(self)


def azimuth_rotation(azimuth_deg: float) -> FloatArray:
    """Rotation (3, 3) about the dome's axis, ``dome_from_tilt``: columns are the tilt frame's axes."""
    angle = np.radians(azimuth_deg)
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
