"""Finite elements: presses of a skin on a rigid obstacle, by the own solver or by CalculiX decks."""

from palpate.fea.ball import Ball, BallSpec
from palpate.fea.branch import Branch
from palpate.fea.calculix import CalculixSolver, CalculixSpec, calculix_recipe, solve_press_calculix
from palpate.fea.contact_traction import contact_traction
from palpate.fea.convergence import MeshResult, study_convergence
from palpate.fea.cylinder import Cylinder, CylinderSpec
from palpate.fea.deck_spec import DeckElement, DeckSpec, Dialect
from palpate.fea.export import check_export, export_press
from palpate.fea.first_contact import find_first_contact
from palpate.fea.io import read_press, write_press
from palpate.fea.monitor import SkinMonitor
from palpate.fea.nodal_stress import nodal_von_mises
from palpate.fea.obstacles import OBSTACLES, obstacle_from_data, read_obstacle
from palpate.fea.plot_convergence import plot_convergence
from palpate.fea.plot_press import plot_press, render_press_3d, tabulate_press
from palpate.fea.press import Press
from palpate.fea.press_recipe import press_recipe
from palpate.fea.press_solver import PRESS_SOLVERS, PalpateSolver, PressSolver
from palpate.fea.solve_press import solve_press
from palpate.fea.spec import CELLS, ObstacleSpec, check_contact
from palpate.fea.stability import Stability, find_stability
from palpate.fea.wall import Plane, WallSpec
from palpate.fea.write_deck import write_deck
from palpate.mechanics import EndReason, SolverSpec

__all__ = [
    "CELLS",
    "OBSTACLES",
    "PRESS_SOLVERS",
    "Ball",
    "BallSpec",
    "Branch",
    "CalculixSolver",
    "CalculixSpec",
    "Cylinder",
    "CylinderSpec",
    "DeckElement",
    "DeckSpec",
    "Dialect",
    "EndReason",
    "MeshResult",
    "ObstacleSpec",
    "PalpateSolver",
    "Plane",
    "Press",
    "PressSolver",
    "SkinMonitor",
    "SolverSpec",
    "Stability",
    "WallSpec",
    "calculix_recipe",
    "check_contact",
    "check_export",
    "contact_traction",
    "export_press",
    "find_first_contact",
    "find_stability",
    "nodal_von_mises",
    "obstacle_from_data",
    "plot_convergence",
    "plot_press",
    "press_recipe",
    "read_obstacle",
    "read_press",
    "render_press_3d",
    "solve_press",
    "solve_press_calculix",
    "study_convergence",
    "tabulate_press",
    "write_deck",
    "write_press",
]
