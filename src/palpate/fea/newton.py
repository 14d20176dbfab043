"""Equilibrium by Newton's method: one increment, from a predicted state to a converged one."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np

from palpate.core import BoolArray, FloatArray
from palpate.fea.contact import ContactLaw, OuterSurface, Plane, Touch, assemble_contact
from palpate.fea.element import System
from palpate.fea.linear import LinearSolver, SingularMatrixError
from palpate.fea.solid import Solid, State

_TRIALS = 5
"""Most trials of a line search."""
_SLOPE_FALL = 0.5
"""Share of the first slope to which a line search goes down."""
_BLOW_UP = 10.0
"""Share of the first slope to which a step along a rising one may raise it."""
_FIRST_SHIFT, _SHIFTS = 1e-3, 8
"""First shift of an indefinite tangent, over mu/T² and the nodal volume, and how often it may grow."""


class Outcome(StrEnum):
    """How an increment ended."""

    CONVERGED = "converged"
    TOO_MANY_ITERATIONS = "too many iterations"
    DIVERGED = "residual grew"
    INVERTED_CELL = "a cell turned inside out"
    SINGULAR = "singular matrix"


@dataclass(frozen=True)
class Damping:
    """Viscous term of a pseudo-time step, ``c/2 |u - u0|²`` weighted by nodal volume.

    Attributes
    ----------
    coefficient
        c, MPa/mm² (zero: none).
    origin
        (n, 3) mm, u0.
    """

    coefficient: float
    origin: FloatArray


class Loads(NamedTuple):
    """What a state stores and bears, of the modelled part.

    Attributes
    ----------
    elastic
        Stored elastic energy, mJ; infinite where a cell is turned inside out.
    contact
        Energy of the contact penalty and of sticking springs, mJ.
    force
        (3,) N on the wall.
    """

    elastic: float
    contact: float
    force: FloatArray


@dataclass(frozen=True)
class Equilibrium:
    """Result of an increment.

    Attributes
    ----------
    outcome
        Reason of the end.
    state
        The last state; an equilibrium only where `outcome` is converged.
    loads
        Energies and force of the modelled part.
    residual
        Greatest out-of-balance force of a degree of freedom, N.
    iterations
        Newton iterations spent.
    negative_pivots
        Inertia of the last tangent; 0 on a stable branch, -1 unknown.
    history
        Residual of every iteration, N.
    """

    outcome: Outcome
    state: State
    loads: Loads
    residual: float
    iterations: int
    negative_pivots: int
    history: tuple[float, ...] = ()

    @property
    def converged(self) -> bool:
        """Whether the state is an equilibrium."""
        return self.outcome is Outcome.CONVERGED


class ContactProblem:
    """A solid pressed by a plane: assembles and solves one increment at a time.

    Parameters
    ----------
    solid
        The body.
    surface
        Its outer surface.
    law
        Contact law.
    linear
        Sparse solver; analysed here once.
    tolerance
        Greatest out-of-balance force in N at convergence.
    thickness
        Thickness of the wall in mm, the scale of steps and shifts.
    """

    def __init__(
        self,
        solid: Solid,
        surface: OuterSurface,
        law: ContactLaw,
        linear: LinearSolver,
        tolerance: float,
        thickness: float,
    ) -> None:
        self.solid, self.surface, self.law, self.linear, self.tolerance = (
            solid,
            surface,
            law,
            linear,
            tolerance,
        )
        linear.analyze(solid.pattern)
        self._system = System(np.empty(len(solid.pattern.column)), np.empty(solid.nodes.size))
        self._volume = np.zeros(len(solid.nodes))
        np.add.at(self._volume, solid.cells.nodes, np.einsum("eg,ga->ea", solid.cells.weight, solid.shape**2))
        self._diagonal = solid.pattern.start[:-1]
        self.thickness = thickness

    def assemble(self, state: State, plane: Plane, touch: Touch) -> Loads:
        """Assemble tangent and residual of solid and contact."""
        solid, system = self.solid, self._system
        system.data[:] = 0.0
        system.residual[:] = 0.0
        energy = solid.assemble(state, system)
        if not np.isfinite(energy):
            return Loads(energy, 0.0, np.zeros(3))
        obstacle = (plane, self.law, touch)
        contact, force = assemble_contact(
            self.surface.faces, solid.cells.place, solid.nodes + state.u, obstacle, system
        )
        return Loads(energy, contact, force)

    def _add_damping(self, state: State, damping: Damping) -> None:
        viscous = damping.coefficient * np.repeat(self._volume, 3)
        residual = self._system.residual
        residual += viscous * (state.u - damping.origin).ravel()
        self._system.data[self._diagonal] += viscous[self.solid.free]

    def solve(
        self,
        start: State,
        plane: Plane,
        touch: Touch,
        iterations: int,
        damping: Damping | None = None,
        slack: float = 1.0,
    ) -> Equilibrium:
        """Find the equilibrium near `start` with the wall at `plane`.

        Parameters
        ----------
        start
            Predicted state.
        plane
            The wall.
        touch
            What the contact points remember.
        iterations
            Most Newton iterations.
        damping
            Viscous term of a pseudo-time step.
        slack
            Factor on the tolerance.

        Returns
        -------
        Equilibrium
            With the reason where it did not converge.
        """
        state, pivots = start, -1
        history: list[float] = []
        loads = self._assemble_all(state, plane, touch, damping)
        for iteration in range(iterations + 1):
            if not np.isfinite(loads.elastic):
                return self._end(Outcome.INVERTED_CELL, state, loads, history, pivots)
            residual = self._system.residual[self.solid.free]
            history.append(float(np.abs(residual).max(initial=0.0)))
            if not np.isfinite(history[-1]):
                return self._end(Outcome.DIVERGED, state, loads, history, pivots)
            if history[-1] <= slack * self.tolerance and iteration > 0:
                return self._end(Outcome.CONVERGED, state, loads, history, pivots)
            if iteration == iterations:
                break
            try:
                pivots, step = self._direction(residual, descend=damping is not None)
            except SingularMatrixError:
                return self._end(Outcome.SINGULAR, state, loads, history, pivots)
            state, loads = self._search(state, step, float(residual @ step), plane, touch, damping)
        return self._end(Outcome.TOO_MANY_ITERATIONS, state, loads, history, pivots)

    def glue(self, start: State, plane: Plane, touch: Touch, touching: BoolArray) -> State:
        """One linear step in which points that are `touching` (n_points,) cannot leave the wall.

        An extrapolated state has lost the wall here and there by micrometres; without those points the tangent
        is nearly singular, and Newton's first steps are lost on it.
        """
        glued = touch._replace(hold=np.where(touching, self.law.stiffness, touch.hold))
        if not np.isfinite(self.assemble(start, plane, glued).elastic):
            return start
        try:
            _, step = self._direction(self._system.residual[self.solid.free], descend=False)
        except SingularMatrixError:
            return start
        du = self._scatter(step)
        factor = min(1.0, self.thickness / max(float(np.abs(du).max()), 1e-300))
        return start.moved(du, self.solid.recover_pressure(du), factor)

    def _scatter(self, step: FloatArray) -> FloatArray:
        """Displacement (n, 3) mm of a step of the free degrees of freedom."""
        du = np.zeros(self.solid.nodes.shape)
        du.ravel()[self.solid.free] = step
        return du

    def _assemble_all(self, state: State, plane: Plane, touch: Touch, damping: Damping | None) -> Loads:
        loads = self.assemble(state, plane, touch)
        if damping is not None and np.isfinite(loads.elastic):
            self._add_damping(state, damping)
        return loads

    def _direction(self, residual: FloatArray, *, descend: bool) -> tuple[int, FloatArray]:
        """Newton step and negative pivots of the tangent; to `descend`, an indefinite tangent is shifted first."""
        pivots = negative = self.linear.refactor(self._system.data)
        shift = _FIRST_SHIFT * self.solid.material.law.shear_modulus / self.thickness**2
        for _ in range(_SHIFTS if descend else 0):
            if negative <= 0:
                break
            self._system.data[self._diagonal] += shift * np.repeat(self._volume, 3)[self.solid.free]
            negative = self.linear.refactor(self._system.data)
            shift *= 9.0
        return pivots, self.linear.solve(-residual)

    def _search(
        self,
        state: State,
        step: FloatArray,
        slope: float,
        plane: Plane,
        touch: Touch,
        damping: Damping | None,
    ) -> tuple[State, Loads]:
        """Go along a step until the slope of the energy has fallen (Matthies & Strang 1979)."""
        du = self._scatter(step)
        dp = self.solid.recover_pressure(du)
        factor = min(1.0, self.thickness / max(float(np.abs(du).max()), 1e-300))
        low, low_slope = 0.0, slope
        for trial in range(_TRIALS):
            moved = state.moved(du, dp, factor)
            loads = self._assemble_all(moved, plane, touch, damping)
            if not np.isfinite(loads.elastic):
                factor *= 0.5
                continue
            here = float(self._system.residual[self.solid.free] @ step)
            if trial == _TRIALS - 1:
                break
            if slope >= 0:  # toward a saddle there is no minimum to bracket; the step must only not blow up
                if abs(here) <= _BLOW_UP * slope:
                    break
                factor *= 0.25
                continue
            if here <= _SLOPE_FALL * abs(slope):
                break
            factor = max(low + (factor - low) * low_slope / (low_slope - here), 0.1 * factor)
        return moved, loads

    @staticmethod
    def _end(outcome: Outcome, state: State, loads: Loads, history: list[float], pivots: int) -> Equilibrium:
        return Equilibrium(
            outcome=outcome,
            state=state,
            loads=loads,
            residual=history[-1] if history else np.inf,
            iterations=max(len(history) - 1, 0),
            negative_pivots=pivots,
            history=tuple(history),
        )
