"""Mechanics: equilibria of a soft body under loads and rigid obstacles, followed along their branches."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
