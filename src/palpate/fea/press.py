"""A press: one simulated contact from first touch to full depth."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TypedDict

import numpy as np

from palpate.core import FloatArray, IntArray, PalpateError, TextArray
from palpate.fea.derivative import Derivative
from palpate.fea.spec import ObstacleSpec
from palpate.material import Material
from palpate.mechanics import EndReason, SolverSpec
from palpate.mesh import Mesh, locate_inner, locate_nodes, marker_displacement, marker_displacement_derivative


class IncrementFields(TypedDict):
    """The fields of a `Press` that have a row for each increment."""

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
    stabilisation_tension: FloatArray
    negative_pivots: IntArray


@dataclass(frozen=True)
class Press:
    """What a press left: one increment at rest, one every increment step, and the last state where it ended early.

    Attributes
    ----------
    mesh, material, obstacle, solver
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
        (n,) `Branch` values, or `NEITHER`.
    peak_stress
        (n,) MPa greatest von Mises Cauchy stress at a Gauss point.
    contact_area
        (n,) mm² deformed area that touches the wall, whole dome.
    apex_gap
        (n,) mm distance between the wall and the point that it touched first.
    stabilisation_tension
        (n,) MPa greatest tension that held the flat patch to the wall (see `palpate.fea.monitor`).
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
    derivatives
        By name, those that `solver` asks for.
    solved_by
        Name of the press solver; only palpate's own presses have stresses at the nodes.
    """

    mesh: Mesh
    material: Material
    obstacle: ObstacleSpec
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
    stabilisation_tension: FloatArray
    negative_pivots: IntArray
    ended: EndReason
    ended_depth: float
    jump_depth: float
    cpu_s: float
    unknowns: int
    newton_iterations: int
    message: str = ""
    derivatives: Mapping[str, Derivative] = field(default_factory=dict)
    solved_by: str = "palpate"

    def derivative(self, name: str, depth: float | None = None) -> Derivative:
        """Derivative of the press by a parameter, at every increment.

        Parameters
        ----------
        name
            One of `derivatives`.
        depth
            Up to where in mm it is wanted; the whole press by default.

        Raises
        ------
        PalpateError
            If it was not asked for when the press was solved, or the branch jumped or ended before that depth: there
            the press does not depend smoothly on anything.
        """
        if name not in self.derivatives:
            known = ", ".join(self.derivatives) or "nothing"
            raise PalpateError(
                f"This press was differentiated by {known}, not by '{name}'.",
                "Ask for it when it is solved: SolverSpec(derivatives=[name]).",
                code="derivative-not-solved",
            )
        depth = self.ended_depth if depth is None else depth
        if self.jump_depth <= depth:
            raise PalpateError(
                f"At {self.jump_depth:.3g} mm the press jumped to another branch: beyond, it has no derivative.",
                f"Ask for less than that: derivative('{name}', depth={0.99 * self.jump_depth:.3g}).",
                code="derivative-beyond-jump",
            )
        lost = self.ended not in (EndReason.DEPTH_REACHED, EndReason.WALL_AT_CLAMP)
        if lost and depth >= self.ended_depth:
            raise PalpateError(
                f"The press ended at {self.ended_depth:.3g} mm ({self.ended}): there it has no derivative.",
                f"Ask for less than that: derivative('{name}', depth={0.99 * self.ended_depth:.3g}).",
                code="derivative-beyond-end",
            )
        return self.derivatives[name]

    def cut(self, first: int, last: int) -> Press:
        """The increments from `first` up to, but not with, `last`; why and where the press ended stays as it is."""
        here = slice(first, last)
        derivatives = {
            name: replace(each, displacement=each.displacement[here], force=each.force[here])
            for name, each in self.derivatives.items()
        }
        return replace(
            self,
            depth=self.depth[here],
            displacement=self.displacement[here],
            force=self.force[here],
            energy=self.energy[here],
            contact_energy=self.contact_energy[here],
            dissipation=self.dissipation[here],
            work=self.work[here],
            branch=self.branch[here],
            peak_stress=self.peak_stress[here],
            contact_area=self.contact_area[here],
            apex_gap=self.apex_gap[here],
            stabilisation_tension=self.stabilisation_tension[here],
            negative_pivots=self.negative_pivots[here],
            derivatives=derivatives,
        )

    def interpolated_to(self, mesh: Mesh) -> Press:
        """The press with its fields interpolated to another mesh of the skin, of as many layers."""
        nodes = locate_nodes(self.mesh, mesh)
        derivatives = {
            name: replace(each, displacement=nodes.interpolate(each.displacement))
            for name, each in self.derivatives.items()
        }
        return replace(self, mesh=mesh, displacement=nodes.interpolate(self.displacement), derivatives=derivatives)

    def positions(self, points: FloatArray) -> FloatArray:
        """Follow points of the undeformed inner surface, or tips of its pins, through every increment.

        Parameters
        ----------
        points
            (m, 3) mm, dome's frame.

        Returns
        -------
        (n, m, 3) mm
            Deformed positions, dome's frame.
        """
        result: FloatArray = np.asarray(points, float) + self.displacement_at(points)
        return result

    def displacement_at(self, points: FloatArray, by: str = "") -> FloatArray:
        """Displacement (n, m, 3) mm of such points (m, 3) mm, or its derivative `by` one of `derivatives`."""
        turn = self.obstacle.turn(self.mesh)
        points = np.asarray(points, float)
        local = points @ turn
        side = np.ones(3)
        mirrored = np.zeros(len(points), bool)
        if not self.mesh.spec.whole:
            mirrored = local[:, 0] < 0
            side = np.array([-1.0, 1.0, 1.0])
        seen = np.where(mirrored[:, None], local * side, local)
        places = locate_inner(self.mesh, seen)
        if by:
            rate = self.derivatives[by]
            side = -side if rate.across else side
            moved = marker_displacement_derivative(
                self.mesh, places, self.displacement, rate.displacement, across=rate.across
            )
        else:
            moved = marker_displacement(self.mesh, places, self.displacement)
        result: FloatArray = np.where(mirrored[:, None], moved * side, moved) @ turn.T
        return result
