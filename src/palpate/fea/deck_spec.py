"""Configuration of a deck: the input file of another finite-element program."""

from __future__ import annotations

from enum import StrEnum

from palpate.core import Spec, parameter


class Dialect(StrEnum):
    """Program that reads a deck."""

    ABAQUS = "abaqus"
    CALCULIX = "calculix"


class DeckElement(StrEnum):
    """Elements of a deck: bricks through the skin thickness, or shells on its middle surface."""

    SOLID = "solid"
    SHELL = "shell"


class DeckSpec(Spec):
    """Dialect, element and contact of a deck."""

    dialect: Dialect = Dialect.ABAQUS
    element: DeckElement = DeckElement.SOLID
    penalty: float = parameter(
        1.0,
        unit="MPa/mm",
        meaning="contact pressure over penetration",
        source="robust in CalculiX; penetration below 0.05 mm",
        gt=0,
        le=1e6,
    )
    tangential_ratio: float = parameter(
        0.2, unit="1", meaning="stick slope of friction over the penalty", gt=0, le=10
    )
    increment: float = parameter(
        0.4, unit="mm", meaning="first and largest increment of the wall", source="robust in CalculiX", gt=0, le=10
    )
    smallest_increment: float = parameter(
        1e-4, unit="mm", meaning="smallest increment before the program gives up", gt=0, le=1
    )
