"""A press: one simulated contact from first contact to full depth."""

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
    """Result of a press: increments at rest, at every depth step, and the last state if it ended early.

    Attributes
    ----------
    mesh, material, obstacle, solver
        Inputs.
    depth
        (n,) mm travel of the wall since first contact.
    displacement
        (n, n_nodes, 3) mm; of a half model in the frame whose y-z plane is the tilt plane, else in the skin's.
    force
        (n, 3) N of the whole skin on the wall, in the skin's frame.
    energy, contact_energy, dissipation, work
        (n,) mJ stored in the whole skin, stored in the contact penalty and sticking springs, lost to friction since
        rest, and done by the wall.
    branch
        (n,) `Branch` values, or `NEITHER`.
    peak_stress
        (n,) MPa maximum von Mises Cauchy stress at a Gauss point.
    contact_area
        (n,) mm² deformed area in contact with the wall, whole skin.
    apex_gap
        (n,) mm distance between the wall and the first-contact point.
    stabilisation_tension
        (n,) MPa maximum tension of the contact stabilisation (see `palpate.fea.monitor`).
    negative_pivots
        (n,) unstable modes of the discrete equilibrium (0: stable; -1: not computed by the linear solver).
    ended, ended_depth, message
        Reason of the end, its depth in mm, and one sentence with numbers if it is not the full depth.
    jump_depth
        Depth in mm at which the branch changed by a jump; nan without a jump.
    cpu_s, unknowns, newton_iterations
        Cost.
    derivatives
        Derivatives that `solver` requests, by name.
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
        """Return the derivative of the press by a parameter, at every increment.

        Parameters
        ----------
        name
            One of `derivatives`.
        depth
            Depth in mm up to which it is needed; the whole press by default.

        Raises
        ------
        PalpateError
            If it was not requested when the press was solved, or the branch jumped or ended before that depth: the
            press is not differentiable there.
        """
        if name not in self.derivatives:
            known = ", ".join(self.derivatives) or "nothing"
            raise PalpateError(
                f"This press was differentiated by {known} and has no derivative by '{name}'.",
                "Solve it with this derivative: SolverSpec(derivatives=[name]).",
                code="derivative-not-solved",
            )
        depth = self.ended_depth if depth is None else depth
        if self.jump_depth <= depth:
            raise PalpateError(
                f"The press jumped to another branch at {self.jump_depth:.3g} mm and has no derivative from there.",
                f"Request a smaller depth: derivative('{name}', depth={0.99 * self.jump_depth:.3g}).",
                code="derivative-beyond-jump",
            )
        lost = self.ended not in (EndReason.DEPTH_REACHED, EndReason.WALL_AT_CLAMP)
        if lost and depth >= self.ended_depth:
            raise PalpateError(
                f"The press ended at {self.ended_depth:.3g} mm ({self.ended}) and has no derivative there.",
                f"Request a smaller depth: derivative('{name}', depth={0.99 * self.ended_depth:.3g}).",
                code="derivative-beyond-end",
            )
        return self.derivatives[name]

    def cut(self, first: int, last: int) -> Press:
        """Return the press with the increments from `first` up to, but without, `last`; its end is unchanged."""
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
        """Interpolate the fields to another mesh of the skin with the same number of layers."""
        nodes = locate_nodes(self.mesh, mesh)
        derivatives = {
            name: replace(each, displacement=nodes.interpolate(each.displacement))
            for name, each in self.derivatives.items()
        }
        return replace(self, mesh=mesh, displacement=nodes.interpolate(self.displacement), derivatives=derivatives)

    def positions(self, points: FloatArray) -> FloatArray:
        """Follow points (m, 3) mm of the undeformed inner surface, or pin tips, through every increment.

        Returns
        -------
        (n, m, 3) mm
            Deformed positions, in the skin's frame like the points.
        """
        result: FloatArray = np.asarray(points, float) + self.displacement_at(points)
        return result

    def displacement_at(self, points: FloatArray, by: str = "") -> FloatArray:
        """Return the displacement (n, m, 3) mm of such points, or its derivative `by` one of `derivatives`."""
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
