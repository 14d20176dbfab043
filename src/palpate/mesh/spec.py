"""What a person may choose about the mesh of a dome."""

from __future__ import annotations

from enum import StrEnum
from typing import Any

from palpate.core import Spec, parameter


class Rim(StrEnum):
    """How the dome ends at its base: cut flat at z = 0 as molded, or radially from the sphere's centre."""

    FLAT = "flat"
    RADIAL = "radial"


class MeshSpec(Spec):
    """Mesh of a dome: cells from pole to rim, layers through the wall, rim, half or whole."""

    cells: int | None = parameter(
        None,
        unit="1",
        meaning="cells along a meridian from pole to rim; empty: chosen from the wall's thickness",
        source="convergence study, docs/decisions",
        ge=4,
        le=200,
    )
    layers: int = parameter(1, unit="1", meaning="cells through the thickness", ge=1, le=8)
    rim: Rim = parameter(Rim.FLAT, unit="", meaning="base cut flat at z = 0, or radially from the sphere's centre")
    whole: bool = parameter(False, unit="", meaning="solve the whole dome, not its half")

    def refined(self, factor: float, cells: int) -> MeshSpec:
        """Return the same mesh with `factor` times the cells along a meridian that has `cells` now."""
        return self.model_copy(update={"cells": round(cells * factor)})

    def key_data(self) -> dict[str, Any]:
        """Return the identity of this spec as plain values."""
        return self.model_dump(mode="json")
