"""Surrogate: the twin: markers and force for any pose and friction, interpolated from presses."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
