"""`palpate design deck`: the input file of a press for Abaqus or CalculiX."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from palpate.cli.output import JsonOutput
from palpate.cli.press import PressFlags
from palpate.fea import DeckElement, DeckSpec, Dialect

_ELEMENT = "Brick elements through the skin thickness, or shells on the mid surface as in the paper (abaqus only)."


def deck(
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"], help="File to write, usually .inp.")],
    dialect: Annotated[Dialect, Parameter(help="Program that reads the deck.")] = Dialect.ABAQUS,
    element: Annotated[DeckElement, Parameter(help=_ELEMENT)] = DeckElement.SOLID,
    flags: PressFlags = PressFlags(),
    json: JsonOutput = JsonOutput(),
) -> None:
    """Write the complete input file of a press in mm, N and MPa."""
    from palpate.fea import write_deck

    mesh, material, wall = flags.problem()
    write_deck(output, mesh, material, wall, DeckSpec(dialect=dialect, element=element))
    facts = {
        "file": str(output),
        "skin": mesh.skin.name,
        "element": element,
        "dialect": dialect,
        "wall": wall.model_dump(mode="json"),
        "material": material.key_data(),
    }
    size_mb = output.stat().st_size / 1e6
    json.show(facts, f"{output}: {mesh.skin.name} of {element} elements for {dialect}, {size_mb:.1f} MB")
