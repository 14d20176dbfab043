"""Fea: press a dome by a rigid wall and say what it does: displacement, force, contact, stress, branch."""

from palpate.fea.contact import ContactLaw, OuterSurface, Plane, Touch, untouched
from palpate.fea.element import System
from palpate.fea.io import read_press, write_press
from palpate.fea.linear import make_linear_solver, solver_backends
from palpate.fea.newton import ContactProblem, Damping, Equilibrium
from palpate.fea.press import FEA_VERSION, Branch, Ended, Press
from palpate.fea.solid import Solid, State
from palpate.fea.solve_press import solve_press
from palpate.fea.spec import SolverSpec, WallSpec, contact_text, read_contact
from palpate.fea.stress import cauchy_stress

__all__ = [
    "FEA_VERSION",
    "Branch",
    "ContactLaw",
    "ContactProblem",
    "Damping",
    "Ended",
    "Equilibrium",
    "OuterSurface",
    "Plane",
    "Press",
    "Solid",
    "SolverSpec",
    "State",
    "System",
    "Touch",
    "WallSpec",
    "cauchy_stress",
    "contact_text",
    "make_linear_solver",
    "read_contact",
    "read_press",
    "solve_press",
    "solver_backends",
    "untouched",
    "write_press",
]
