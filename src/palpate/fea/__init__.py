"""Fea: press a dome by a rigid wall and say what it does: displacement, force, contact, stress, branch."""

from palpate.fea.io import read_press, write_press
from palpate.fea.linear import solver_backends
from palpate.fea.press import FEA_VERSION, Branch, Ended, Press
from palpate.fea.solve_press import solve_press
from palpate.fea.spec import SolverSpec, WallSpec, contact_text, read_contact

__all__ = [
    "FEA_VERSION",
    "Branch",
    "Ended",
    "Press",
    "SolverSpec",
    "WallSpec",
    "contact_text",
    "read_contact",
    "read_press",
    "solve_press",
    "solver_backends",
    "write_press",
]
