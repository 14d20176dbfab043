"""Simulation: one manufactured unit of a design, its images and forces by a twin or by solved presses, and trials."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
