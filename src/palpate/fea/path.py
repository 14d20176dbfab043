"""Follow a branch of equilibria as the wall moves: predictor, increments, and the detection of jumps.

Each increment starts from a polynomial through the last equilibria. It is accepted only if it is an equilibrium,
*continuous*: the energy gained must be the work done, and the apex must not have moved off the wall or back.
Where it is not, Newton's method has fallen onto another branch, and the increment is shortened. The number of
negative pivots is recorded: a flat thin dome is held by almost no pressure at its apex, and a discrete one may
be weakly unstable there while its branch goes on. A branch that cannot be followed in
increments of the smallest size has ended; then the dome jumps: pseudo-time steps with a viscosity that fades to
zero carry it to the next stable state, and the depth and the energy lost are reported. Where the branch is lost
because silicone squeezed against the clamp folds, the press ends: what follows is not modelled.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from palpate.core import FloatArray
from palpate.fea.contact import Plane, Touch
from palpate.fea.hold import patch_middle
from palpate.fea.newton import ContactProblem, Damping, Equilibrium, Loads
from palpate.fea.press import Ended
from palpate.fea.solid import State
from palpate.fea.spec import SolverSpec
from palpate.fea.stress import smallest_stretch

_JUMP_STEP_MM = 0.02
"""An increment this small that still breaks the energy balance is a jump of the dome, not of the solver."""
_IMBALANCE = 0.06
"""Greatest share by which the energy gained may miss the work (trapezoid) of a continuous increment."""
_INVERTED_GAP = 0.1
"""Gap of the first-touched point over the thickness from which the apex counts as inverted."""
_ORDER = 2
_HOLD, _HOLD_FROM = 0.01, 1.5
"""Spring that holds the patch over the contact penalty, and the travel over the thickness from which it does."""
_RELEASE_STEP_MM = 0.1
"""Increment below which a lost flat branch is let go."""
_JUMPS = 4
"""Most jumps of a press."""
_RELAXATIONS, _FADED = 40, 1e-3
"""Most pseudo-time steps of a jump, and the viscosity over mu/area at which it has faded."""
_FOLDING_STRETCH = 0.544
"""Stretch at which a free surface under plane strain compression is unstable (Biot 1963); it creases from 0.647."""
_SLACK = 1e2
"""Slack on the tolerance of friction passes that are not the last, and of pseudo-time steps."""
_PASSES = 4
"""Most passes in which friction limits are corrected."""


def _agree(old: FloatArray, new: FloatArray) -> bool:
    """Whether the friction limits (n,) of two passes are the same traction within 2 %; no slip has but one."""
    if np.isinf(new).any():
        return True
    return bool(np.abs(new - old).sum() <= 0.02 * new.sum())


@dataclass(frozen=True)
class Point:
    """One accepted equilibrium of the whole dome.

    Attributes
    ----------
    depth
        mm travel of the wall.
    state
        Displacement and pressure.
    loads
        Energies and force of the modelled part.
    touch
        What the contact points remember.
    jumped
        Whether a jump led here.
    negative_pivots
        Unstable modes of the equilibrium; -1 where the linear solver cannot tell.
    tension
        MPa, greatest tension of the springs that hold the flat patch.
    dissipated
        mJ of friction in the modelled part, from the start of the path.
    """

    depth: float
    state: State
    loads: Loads
    touch: Touch
    jumped: bool = False
    negative_pivots: int = 0
    tension: float = 0.0
    dissipated: float = 0.0


@dataclass
class Path:
    """A branch under continuation.

    Attributes
    ----------
    problem
        Solid, contact and linear solver.
    wall
        Plane of the wall at a depth in mm.
    probe
        Contact point that touches first; its gap tells the branch.
    spec
        Steps, iterations and tolerance.
    points
        Accepted equilibria; the first is the start.
    iterations
        Newton iterations spent so far, rejected increments included.
    jumps
        Whether the path jumps where its branch ends.
    ended, message
        Why the path could not go on, and that in one sentence; `Ended.DEPTH_REACHED` while it can.
    """

    problem: ContactProblem
    wall: Callable[[float], Plane]
    probe: int
    spec: SolverSpec
    points: list[Point]
    iterations: int = 0
    jumps: bool = True
    ended: Ended = Ended.DEPTH_REACHED
    message: str = ""
    _step: float = field(default=0.0, init=False)
    _touch: Touch = field(init=False)
    _hold: FloatArray = field(init=False)
    _released: bool = field(default=False, init=False)
    _way: float = field(default=1.0, init=False)
    _since: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        self._step = self.spec.first_step
        self._touch = self.points[0].touch
        self._hold = self._touch.hold

    def advance(self, depth: float) -> bool:
        """Follow the branch to a depth in mm, deeper or back; False where it could not be reached (see `ended`)."""
        while abs(left := depth - self.points[-1].depth) > 1e-9:
            step = min(self._step, abs(left))
            if step < abs(left) < 1.5 * step:
                step = abs(left) / 2
            way = 1.0 if left > 0 else -1.0
            if way != self._way:
                self._way, self._since = way, len(self.points) - 1
            if not self._increment(step, way):
                return False
        return True

    def invert(self, push: float) -> bool:
        """Push the apex off the wall by `push` mm at the depth reached; whether it rests there, inverted.

        On success the path goes on from the inverted state and does not jump.
        """
        last = self.points[-1]
        self._released, self._hold = True, np.zeros_like(self._hold)
        found = self._relax(last.depth, push)
        if not found.converged or not self.inverted(found.state, last.depth):
            return False
        self._accept(found, last.depth, jumped=True)
        self.points, self.jumps, self._since = [self.points[-1]], False, 0
        self._step = min(self.spec.first_step, self.spec.largest_step)
        return True

    def _increment(self, step: float, way: float) -> bool:
        last = self.points[-1]
        depth = last.depth + way * step
        found = self._solve(depth, self._glue(depth, self._predict(depth)))
        if self._acceptable(found, depth):
            tension = self._tension(found.state, depth)
            if tension <= self.spec.adhesion * self.problem.solid.material.young_modulus:
                self._accept(found, depth, jumped=False)
                self._step = self._next_step(step, found.iterations)
                return True
            if step <= _RELEASE_STEP_MM:
                return self._jump(depth)
        self._step = step / 2 if found.iterations < self.spec.iterations else step / 3
        if self._step >= self.spec.smallest_step and not (found.converged and step <= _JUMP_STEP_MM):
            return True
        return self._jump(last.depth + way * min(step, _JUMP_STEP_MM))

    def _next_step(self, step: float, iterations: int) -> float:
        factor = 2.0 if iterations <= 10 else 1.4 if iterations <= 15 else 0.8
        largest = self.spec.largest_step
        if self.problem.law.friction > 0:
            share = self.spec.friction_share * self.points[-1].depth
            largest = min(largest, max(share, self.spec.first_step))
        return min(max(step, self._step) * factor, largest)

    def _solve(
        self, depth: float, start: State, damping: Damping | None = None, *, sliding: bool = False
    ) -> Equilibrium:
        """Equilibrium at a depth; with friction in passes, until sticking places and limits agree with it.

        In a jump all points are `sliding`; they stick where they come to rest.
        """
        plane, last, law = self.wall(depth), self.points[-1], self.problem.law
        before = (self._surface_points(last.state), self.wall(last.depth))
        touch, passes = last.touch._replace(hold=self._hold), 0
        if sliding:
            touch = touch._replace(limit=np.zeros_like(touch.limit))
        rough = (law.friction > 0 and not sliding) or damping is not None
        while True:
            slack = _SLACK if rough else 1.0
            found = self.problem.solve(start, plane, touch, self.spec.iterations, damping, slack)
            self.iterations += found.iterations
            self._touch, passes = touch, passes + 1
            if not rough or damping is not None or not found.converged:
                return found
            touch = self.problem.surface.correct(law, touch, before, (self._surface_points(found.state), plane))
            start = found.state
            rough = passes < _PASSES and not _agree(self._touch.limit, touch.limit)

    def _glue(self, depth: float, predicted: State) -> State:
        """The predicted state, with the points that touch at the last equilibrium drawn to the wall."""
        last = self.points[-1]
        plane = self.wall(last.depth)
        touching = (self._surface_points(last.state) - plane.point) @ plane.normal > 0
        self.iterations += 1
        return self.problem.glue(predicted, self.wall(depth), last.touch._replace(hold=self._hold), touching)

    def _surface_points(self, state: State) -> FloatArray:
        return self.problem.surface.interpolate(self.problem.solid.nodes + state.u)

    def _predict(self, depth: float) -> State:
        """Extrapolate the last equilibria, since a jump or a turn of the wall, by a polynomial in depth."""
        known = self.points[max(self._since, len(self.points) - _ORDER - 1) :]
        at = np.array([point.depth for point in known])
        u, p = np.zeros_like(known[0].state.u), np.zeros_like(known[0].state.p)
        for k, point in enumerate(known):
            others = np.delete(at, k)
            share = float(np.prod((depth - others) / (at[k] - others)))
            u += share * point.state.u
            p += share * point.state.p
        return State(u, p)

    def _acceptable(self, found: Equilibrium, depth: float) -> bool:
        last = self.points[-1]
        if not found.converged or self.inverted(found.state, depth) != self.inverted(last.state, last.depth):
            return False
        if len(self.points) < 3:
            return True
        work = 0.5 * (found.loads.force[2] + last.loads.force[2]) * (depth - last.depth)
        gained = sum(found.loads[:2]) - sum(last.loads[:2])
        tolerance = _IMBALANCE if self.problem.law.friction == 0 else 3 * _IMBALANCE
        return bool(abs(gained - work) <= tolerance * abs(work) + 1e-9)

    def gap(self, state: State, depth: float) -> float:
        """Distance in mm between the wall at a depth and the point that it touched first."""
        plane = self.wall(depth)
        return -float((self._surface_points(state)[self.probe] - plane.point) @ plane.normal)

    def inverted(self, state: State, depth: float) -> bool:
        """Whether the apex has left the wall: more than a tenth of the thickness (flat: some micrometres)."""
        return self.gap(state, depth) > _INVERTED_GAP * self.problem.thickness

    def _accept(self, found: Equilibrium, depth: float, *, jumped: bool) -> None:
        plane = self.wall(depth)
        x = self._surface_points(found.state)
        surface, law = self.problem.surface, self.problem.law
        slipped = surface.dissipate(law, self._touch, x, plane)
        self.points.append(
            Point(
                depth,
                found.state,
                found.loads._replace(contact=found.loads.contact - slipped),
                surface.settle(law, self._touch, x, plane),
                jumped,
                found.negative_pivots,
                self._tension(found.state, depth),
                self.points[-1].dissipated + slipped,
            )
        )
        if not self._released and depth > _HOLD_FROM * self.problem.thickness:
            held = patch_middle(self.problem.surface.points, plane.normal, (x - plane.point) @ plane.normal > 0)
            self._hold = np.where(held, _HOLD * self.problem.law.stiffness, 0.0)

    def _tension(self, state: State, depth: float) -> float:
        """Greatest tension in MPa that holds the middle of the patch to the wall."""
        plane = self.wall(depth)
        lift = (plane.point - self._surface_points(state)) @ plane.normal
        return float((self._hold * np.maximum(lift, 0.0)).max(initial=0.0))

    def _jump(self, depth: float) -> bool:
        """Let go of the patch, push its middle off the wall, and relax to the next stable state at `depth` mm."""
        if self._folded():
            return False
        if not self.jumps:
            self._end(Ended.BRANCH_ENDED, "where the branch ends")
            return False
        self._released, self._hold = True, np.zeros_like(self._hold)
        if sum(point.jumped for point in self.points) >= _JUMPS:
            self._end(Ended.NOT_CONVERGED, f"after {_JUMPS} jumps: no branch can be followed further")
            return False
        for push in (0.0, 1.0, 2.0) if self.inverted(self.points[-1].state, self.points[-1].depth) else (1.0, 2.0):
            found = self._relax(depth, push * self.problem.thickness)
            if found.converged:
                self._accept(found, depth, jumped=True)
                self._since = len(self.points) - 1
                self._step = min(self.spec.first_step, self.spec.largest_step)
                return True
        self._end(
            Ended.NOT_CONVERGED,
            f"where no equilibrium was found: {found.outcome} after {found.iterations} iterations, residual "
            f"{found.residual:.2g} N is above {self.problem.tolerance:.2g} N",
        )
        return False

    def _folded(self) -> bool:
        """End the path where silicone is squeezed so far that its free surface folds on itself."""
        stretch, place = smallest_stretch(self.problem.solid, self.points[-1].state)
        if stretch >= _FOLDING_STRETCH:
            return False
        where = ", ".join(f"{value:.1f}" for value in place)
        self._end(
            Ended.FOLDED,
            f"where the silicone at ({where}) mm is squeezed to {stretch:.2f} of its length: below "
            f"{_FOLDING_STRETCH:g} a free surface folds",
        )
        return True

    def _end(self, ended: Ended, reason: str) -> None:
        self.ended, self.message = ended, f"The press ended at {self.points[-1].depth:.4g} mm, {reason}."

    def _relax(self, depth: float, push: float) -> Equilibrium:
        """Relax from the last equilibrium, pushed off the wall by `push` mm, under a viscosity that fades to zero."""
        solid, surface, last = self.problem.solid, self.problem.surface, self.points[-1]
        normal = self.wall(depth).normal
        away = np.linalg.norm(solid.nodes - surface.points[self.probe], axis=1)
        width = np.sqrt(max(last.depth, 1.0) * np.linalg.norm(surface.points[self.probe])) / 2
        state = State(last.state.u - push * np.exp(-((away / width) ** 2))[:, None] * normal, last.state.p)
        scale = solid.material.law.shear_modulus / surface.area
        coefficient, origin = 10.0 * scale, state.u
        start = last.state
        for _ in range(_RELAXATIONS):
            found = self._solve(depth, start, Damping(coefficient, origin), sliding=True)
            if found.converged:
                start, origin = found.state, found.state.u
                if coefficient < _FADED * scale:
                    found = self._solve(depth, start, sliding=True)
                    if found.converged:
                        return found
                    coefficient *= 100.0
                coefficient /= 30.0 if found.iterations <= 2 else 4.0 if found.iterations <= 8 else 2.0
            else:
                coefficient *= 3.0
        return found
