"""Branches of equilibria of a pressed skin."""

from enum import StrEnum


class Branch(StrEnum):
    """Branch of an increment of a press."""

    FLAT = "flat"
    INVERTED = "inverted"


NEITHER = "neither"
"""Branch of a state whose apex is off the wall, but which is not proved inverted (see `palpate.fea.inverted`)."""
