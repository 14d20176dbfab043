"""What a person may choose about the mesh of a dome."""

from __future__ import annotations

from typing import Any

from pydantic import SerializerFunctionWrapHandler, model_serializer

from palpate.core import Spec, parameter
from palpate.design import Rim


class MeshSpec(Spec):
    """Mesh of a dome: cells from pole to rim, layers through the wall, rim, half or whole."""

    cells: int | None = parameter(
        None,
        unit="1",
        meaning="cells along a meridian from pole to rim; empty: chosen from the wall's thickness",
        source="convergence study, docs/design_notes/mesh.md",
        ge=4,
        le=200,
    )
    core: int | None = parameter(
        None,
        unit="1",
        meaning="half the cells along a side of the square in the middle; four times as many lie along half a turn",
        source="docs/design_notes/mesh.md",
        ge=1,
        le=40,
    )
    centred: bool = parameter(True, unit="", meaning="a press moves the pole of the mesh to where it touches first")
    layers: int = parameter(1, unit="1", meaning="cells through the thickness", ge=1, le=8)
    rim: Rim = parameter(Rim.FLAT, unit="", meaning="base cut flat at z = 0, or radially from the sphere's centre")
    whole: bool = parameter(False, unit="", meaning="solve the whole dome, not its half")
    filled: bool = parameter(
        False, unit="", meaning="mesh what fills the skin too; so where the material names a gel"
    )

    @model_serializer(mode="wrap")
    def _leave_out_what_is_hollow(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """A hollow skin is written as before there were others: artefacts keep their keys."""
        content: dict[str, Any] = dump(self)
        return {name: value for name, value in content.items() if name != "filled" or value}
