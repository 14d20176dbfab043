"""Mechanics: a soft body under loads and rigid obstacles, in equilibrium, followed along its branches."""

from palpate.mechanics.compiled import kernels_compiled
from palpate.mechanics.continuation import Continuation
from palpate.mechanics.element import System
from palpate.mechanics.friction import ContactLaw
from palpate.mechanics.increment import Increment
from palpate.mechanics.linear import LinearSolver, Pattern, SingularMatrixError, make_linear_solver, solver_backends
from palpate.mechanics.loading import ContactLoading, DeadLoading
from palpate.mechanics.monitor import EndReason, Monitor, NullMonitor
from palpate.mechanics.newton import Equilibrium, Problem
from palpate.mechanics.obstacle import Gap, Obstacle, grid_quads, tangents
from palpate.mechanics.sensitivity import Sensitivity, Variation
from palpate.mechanics.serendipity import BRICK, fill_nodes
from palpate.mechanics.solid import GAUSS, Solid, State
from palpate.mechanics.spec import BASE_RADIUS, SolverSpec
from palpate.mechanics.stress import cauchy_stress, smallest_stretch, von_mises
from palpate.mechanics.surface import OuterSurface
from palpate.mechanics.term import DeadLoad, Term

__all__ = [
    "BASE_RADIUS",
    "BRICK",
    "GAUSS",
    "ContactLaw",
    "ContactLoading",
    "Continuation",
    "DeadLoad",
    "DeadLoading",
    "EndReason",
    "Equilibrium",
    "Gap",
    "Increment",
    "LinearSolver",
    "Monitor",
    "NullMonitor",
    "Obstacle",
    "OuterSurface",
    "Pattern",
    "Problem",
    "Sensitivity",
    "SingularMatrixError",
    "Solid",
    "SolverSpec",
    "State",
    "System",
    "Term",
    "Variation",
    "cauchy_stress",
    "fill_nodes",
    "grid_quads",
    "kernels_compiled",
    "make_linear_solver",
    "smallest_stretch",
    "solver_backends",
    "tangents",
    "von_mises",
]
