"""Fea: press a dome by a rigid wall and say what it does: displacement, force, contact, stress, branch."""

from palpate.fea.compiled import kernels_compiled
from palpate.fea.contact import ContactLaw, OuterSurface, Plane, Touch, untouched
from palpate.fea.convergence import CELLS, MeshResult, study_convergence
from palpate.fea.element import System
from palpate.fea.export import check_export, export_press
from palpate.fea.io import read_press, write_press
from palpate.fea.linear import make_linear_solver, solver_backends
from palpate.fea.newton import ContactProblem, Damping, Equilibrium
from palpate.fea.plot_convergence import plot_convergence
from palpate.fea.press import FEA_VERSION, Branch, Ended, Press, azimuth_rotation
from palpate.fea.serendipity import BRICK, fill_nodes
from palpate.fea.solid import Solid, State
from palpate.fea.solve_press import image_depths, solve_press
from palpate.fea.spec import FRICTIONLESS, NO_SLIP, SolverSpec, WallSpec, contact_text, read_contact
from palpate.fea.stability import Stability, find_stability
from palpate.fea.stress import cauchy_stress, von_mises
from palpate.fea.wall import clamp_depth, normal_in_mesh, touch_point, wall_at

__all__ = [
    "BRICK",
    "CELLS",
    "FEA_VERSION",
    "FRICTIONLESS",
    "NO_SLIP",
    "Branch",
    "ContactLaw",
    "ContactProblem",
    "Damping",
    "Ended",
    "Equilibrium",
    "MeshResult",
    "OuterSurface",
    "Plane",
    "Press",
    "Solid",
    "SolverSpec",
    "Stability",
    "State",
    "System",
    "Touch",
    "WallSpec",
    "azimuth_rotation",
    "cauchy_stress",
    "check_export",
    "clamp_depth",
    "contact_text",
    "export_press",
    "fill_nodes",
    "find_stability",
    "image_depths",
    "kernels_compiled",
    "make_linear_solver",
    "normal_in_mesh",
    "plot_convergence",
    "read_contact",
    "read_press",
    "solve_press",
    "solver_backends",
    "study_convergence",
    "touch_point",
    "untouched",
    "von_mises",
    "wall_at",
    "write_press",
]
