"""Deck: the same press for Abaqus and CalculiX, and CalculiX as a second solver."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
