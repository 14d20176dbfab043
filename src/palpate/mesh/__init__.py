"""Mesh: from a dome to quadratic hexahedra with named sets, and from any surface point to its cell."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
