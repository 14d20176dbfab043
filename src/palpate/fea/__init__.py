"""Finite elements: presses of a skin on a rigid obstacle, by the own solver or by CalculiX decks."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
