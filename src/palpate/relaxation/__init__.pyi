"""Relaxation: how stress and force fade while a strain stays, fitted to tests and followed through time."""

from palpate.relaxation.course import (
    ForceCurve,
    WallHistory,
    simulate_compliant_hold,
    simulate_depth_hold,
    simulate_force_hold,
)
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
    "WallHistory",
    "draw_relaxation",
    "fit_relaxation",
    "relax_history",
    "simulate_compliant_hold",
    "simulate_depth_hold",
    "simulate_force_hold",
]
