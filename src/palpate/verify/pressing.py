"""Press of a body from above by a rigid frictionless obstacle, by palpate's continuation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from palpate.core import FloatArray, IntArray, PalpateError
from palpate.fea import Plane, SkinMonitor
from palpate.mechanics import (
    ContactLaw,
    ContactLoading,
    Continuation,
    Increment,
    Obstacle,
    OuterSurface,
    Problem,
    Solid,
    SolverSpec,
    State,
    make_linear_solver,
)

DOWN = np.array([0.0, 0.0, 1.0])
"""Normal of the obstacle, away from the body below it."""
_STEPS = SolverSpec(largest_step=10.0, smallest_step=1e-4, iterations=60, adhesion=0.1)
_THICKNESS = 2.0
"""Size in mm of a body to which the increments of a `SolverSpec` refer: a usual thickness of a skin."""


class Pressing:
    """A body under a descending obstacle.

    Parameters
    ----------
    solid
        The body.
    outer
        (k,) cells whose face zeta = +1 is a contact surface.
    obstacle
        The obstacle at first contact; or the height of a plane there, mm.
    contact
        Contact stiffness, MPa/mm, and width of its smooth start, mm.
    tolerance
        Maximum residual, N.
    size
        Maximum displacement of a Newton step, mm; of a shell its thickness.
    """

    def __init__(
        self,
        solid: Solid,
        outer: IntArray,
        obstacle: Obstacle | float,
        contact: tuple[float, float],
        tolerance: float,
        size: float,
    ) -> None:
        self.solid, self.size = solid, size
        self.surface = OuterSurface(solid.nodes, solid.cells.nodes[outer][:, 18:27], outer)
        self.law = ContactLaw(stiffness=contact[0], width=contact[1], tangential_stiffness=1.0, friction=0.0)

        first = Plane(DOWN, obstacle * DOWN) if isinstance(obstacle, float) else obstacle

        def lowered(depth: float) -> Obstacle:
            return first.moved(-depth * DOWN)

        self.loading = ContactLoading(solid.nodes, self.surface, self.law, lowered)
        self.problem = Problem(solid, make_linear_solver(), tolerance, size)

    def start(self, length: float, *, stabilised: bool = False) -> Continuation:
        """Return a path from rest whose first increment is `length` mm, on request with stabilised contact."""
        probe, unit = int(self.surface.points[:, 2].argmax()), self.size / _THICKNESS
        monitor = SkinMonitor(self.solid, self.loading, probe, DOWN, self.size, unit, np.zeros(3))
        spec = _STEPS.model_copy(update={"first_step": min(length / unit, _STEPS.largest_step)})
        path = Continuation(self.problem, self.loading, monitor, spec, unit=unit, jumps=False)
        if not stabilised:
            path.release()
        return path

    def follow(self, depths: Sequence[float], *, stabilised: bool = False) -> list[Increment]:
        """Follow the equilibria from rest to every depth, mm.

        Raises
        ------
        PalpateError
            If no increment, however small, leads to the next depth.
        """
        path = self.start(max(depths), stabilised=stabilised)
        return [advance_to(path, depth) for depth in depths]

    def relax(self, depth: float, shape: FloatArray) -> Continuation:
        """Return a path that begins at the equilibrium near a shape (n, 3) mm at a depth, mm.

        Raises
        ------
        PalpateError
            If no equilibrium is found there.
        """
        path = self.start(self.size)
        if not path.settle(depth, shape, State(shape, self.solid.rest().p)):
            raise PalpateError(
                f"No equilibrium was found at {depth:.4g} mm.", "Refine the mesh.", code="equilibrium-not-found"
            )
        return path

    def reach(self, found: Increment) -> FloatArray:
        """Penetration (n_points,) in mm of every contact point, negative outside the obstacle."""
        return self.loading.penetration(found.depth, found.state)


def advance_to(path: Continuation, depth: float) -> Increment:
    """Advance to the increment at a depth in mm.

    Raises
    ------
    PalpateError
        If the branch ends before.
    """
    if not path.advance(depth):
        raise PalpateError(
            f"No equilibrium beyond {path.last.depth:.4g} mm: {path.message}", "Refine the mesh.", code="path-ended"
        )
    return path.last
