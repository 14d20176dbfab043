"""Markers: from images to dots, their numbers and their paths through a press."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
