"""Skins, marker layouts, poses, and the geometry of solids."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
