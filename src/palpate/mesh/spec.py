"""Configuration of the mesh of a skin."""

from __future__ import annotations

from typing import Any

from pydantic import SerializerFunctionWrapHandler, model_serializer

from palpate.core import Spec, parameter
from palpate.design import Rim


class MeshSpec(Spec):
    """Mesh of a skin: cells from pole to rim, layers through the thickness, rim, half or whole model."""

    cells: int | None = parameter(
        None,
        unit="1",
        meaning="cells along a meridian from pole to rim; empty: by the skin thickness",
        source="convergence study, docs/design_notes/mesh.md",
        ge=4,
        le=200,
    )
    core: int | None = parameter(
        None,
        unit="1",
        meaning="half the cells along a side of the central square; a half circle has four times this number",
        source="docs/design_notes/mesh.md",
        ge=1,
        le=40,
    )
    centred: bool = parameter(True, unit="", meaning="move the pole of the mesh to the point of first contact")
    layers: int = parameter(1, unit="1", meaning="cells through the skin thickness", ge=1, le=8)
    rim: Rim = parameter(
        Rim.FLAT, unit="", meaning="cut of the base: flat at z = 0, or radially from the sphere's centre"
    )
    whole: bool = parameter(False, unit="", meaning="solve the whole skin instead of a half model")
    filled: bool = parameter(False, unit="", meaning="mesh the gel inside the skin as well; always with --gel")

    @model_serializer(mode="wrap")
    def _leave_out_what_is_hollow(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out `filled` of a hollow skin, so that older artefacts keep their keys."""
        content: dict[str, Any] = dump(self)
        return {name: value for name, value in content.items() if name != "filled" or value}
