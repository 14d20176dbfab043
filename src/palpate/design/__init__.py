"""Design: from height, base radius, thickness and markers to the geometry of a dome and its limits."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
