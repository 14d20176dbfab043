"""Fabricate: from a design to the workshop: mold, print pattern, enclosure and instructions."""

from palpate.core import lazy_front

lazy_front(__name__, __file__)
