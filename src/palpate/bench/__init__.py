"""Bench: virtual units that deviate from the design, played from image to pose."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
