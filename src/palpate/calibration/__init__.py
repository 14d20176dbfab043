"""Calibration: deviations of built units, what images tell of them, and their predicted accuracy."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
