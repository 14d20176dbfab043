"""Fea: press a dome by a rigid wall and say what it does: displacement, force, contact, stress, branch."""

from palpate.fea.calculix import CalculixSpec, solve_press_calculix
from palpate.fea.compiled import kernels_compiled
from palpate.fea.contact import ContactLaw, OuterSurface, Plane, Touch, untouched
from palpate.fea.convergence import CELLS, MeshResult, study_convergence
from palpate.fea.deck import deck_text, write_deck
from palpate.fea.deck_spec import DeckElement, DeckSpec, Dialect
from palpate.fea.element import System
from palpate.fea.export import check_export, export_press
from palpate.fea.io import read_press, write_press
from palpate.fea.linear import make_linear_solver, solver_backends
from palpate.fea.newton import ContactProblem, Damping, Equilibrium
from palpate.fea.plot_convergence import plot_convergence
from palpate.fea.press import FEA_VERSION, Branch, Ended, Press
from palpate.fea.solid import Solid, State
from palpate.fea.solve_press import solve_press
from palpate.fea.spec import SolverSpec, WallSpec, check_contact
from palpate.fea.stability import Stability, find_stability
from palpate.fea.stress import cauchy_stress

__all__ = [
    "CELLS",
    "FEA_VERSION",
    "Branch",
    "CalculixSpec",
    "ContactLaw",
    "ContactProblem",
    "Damping",
    "DeckElement",
    "DeckSpec",
    "Dialect",
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
    "cauchy_stress",
    "check_contact",
    "check_export",
    "deck_text",
    "export_press",
    "find_stability",
    "kernels_compiled",
    "make_linear_solver",
    "plot_convergence",
    "read_press",
    "solve_press",
    "solve_press_calculix",
    "solver_backends",
    "study_convergence",
    "untouched",
    "write_deck",
    "write_press",
]
