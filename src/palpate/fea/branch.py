"""Branches of equilibria of a pressed skin."""

from enum import StrEnum


class Branch(StrEnum):
    """Branch of an increment of a press."""

    FLAT = "flat"
    INVERTED = "inverted"


NEITHER = "neither"
"""Branch of a state whose apex has left the wall, but that fails the checks of `palpate.fea.inverted`."""
