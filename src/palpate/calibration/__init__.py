"""Calibration of built units: deviations, identification from images, and predicted accuracy."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
