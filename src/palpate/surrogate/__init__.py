"""Surrogate: the twin, which interpolates markers and force from presses for any pose and friction."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
