"""Mechanics: a soft body under loads and rigid obstacles, in equilibrium, followed along its branches."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
