"""Simulation: manufactured units, their images and forces by a twin or solved presses, and trials."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
