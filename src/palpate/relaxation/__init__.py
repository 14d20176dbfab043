"""Relaxation: how stress and force fade while a strain stays, fitted to tests and followed through time."""

from palpate.relaxation.course import ForceCurve, WallCourse, hold_force, hold_wall, sink_wall
from palpate.relaxation.draw_relaxation import draw_relaxation
from palpate.relaxation.fit_relaxation import RelaxationFit, fit_relaxation
from palpate.relaxation.held_test import RelaxationTest
from palpate.relaxation.history import StressHistory, relax_history
from palpate.relaxation.relaxation import Moduli, Relaxation

__all__ = [
    "ForceCurve",
    "Moduli",
    "Relaxation",
    "RelaxationFit",
    "RelaxationTest",
    "StressHistory",
    "WallCourse",
    "draw_relaxation",
    "fit_relaxation",
    "hold_force",
    "hold_wall",
    "relax_history",
    "sink_wall",
]
