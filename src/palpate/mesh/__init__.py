"""Mesh: quadratic hexahedra of a skin with named sets, and the cell of any surface point."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
