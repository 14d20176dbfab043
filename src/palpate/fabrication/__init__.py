"""Fabrication: molds, artwork, drawings and instructions of a design."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
