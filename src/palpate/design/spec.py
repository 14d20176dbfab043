"""Configuration of a skin and its markers."""

from __future__ import annotations

from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any

from pydantic import SerializerFunctionWrapHandler, field_validator, model_serializer, model_validator
from pydantic_core import PydanticCustomError

from palpate.core import PAPER, Spec, parameter
from palpate.design.rings import MAX_RINGS, markers_in_rings, ring_count
from palpate.design.skin import Skin


class SkinSpec(Spec, ABC):
    """Skin over a round base, with dimensions of its inner surface.

    A subclass adds its parameters and a ``kind`` that names it in files; only the dome has no ``kind``.
    """

    height: float = parameter(
        20.0, unit="mm", meaning="height of the inner surface's apex above the base", source=PAPER, ge=2, le=60
    )
    base_radius: float = parameter(
        20.0, unit="mm", meaning="radius of the inner surface's rim", source=PAPER, ge=5, le=60
    )
    thickness: float = parameter(
        2.0,
        unit="mm",
        meaning="skin thickness, outward from the inner surface",
        source=PAPER,
        ge=0.2,
        le=15,
    )

    @abstractmethod
    def build(self) -> Skin:
        """Build the geometry of this skin.

        Raises
        ------
        PalpateError
            If no skin has these dimensions.
        """


class TaperedSpec(SkinSpec, ABC):
    """Skin whose thickness may increase or decrease from apex to rim."""

    taper: float = parameter(
        1.0, unit="1", meaning="ratio of the skin thickness at the rim to that at the apex", ge=0.3, le=3
    )

    @model_serializer(mode="wrap")
    def _leave_out_what_is_even(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out the taper of an even skin, so that older artefacts keep their keys."""
        content: dict[str, Any] = dump(self)
        return {name: value for name, value in content.items() if name != "taper" or value != 1.0}


class MountSpec(Spec):
    """Flange by which a skin is clamped, cast in one piece with it."""

    flange_width: float = parameter(
        6.0, unit="mm", meaning="width of the flange beyond the skin at the base", ge=2, le=30
    )
    flange_thickness: float = parameter(3.0, unit="mm", meaning="thickness of the flange below the base", ge=1, le=10)
    draft_deg: float = parameter(
        1.0, unit="deg", meaning="draft angle of the flange's edges, wider away from the skin", ge=0, le=10
    )


_ROWS = ("rows", "around", "pitch")


class MarkerSpec(Spec):
    """Markers on the inner surface: preset or given rings, rows around a tube, or a free layout."""

    count: int = parameter(
        169,
        unit="1",
        meaning="number of markers, 1 + 3 n (n + 1) for n rings about the apex",
        source=PAPER,
        flag="markers",
        ge=1,
    )
    ring_diameters: tuple[float, ...] | None = parameter(
        None,
        unit="mm",
        meaning="diameters of the rings, projected on the base plane; ring k has 6 k markers",
        flag="rings",
    )
    rows: int | None = parameter(
        None,
        unit="1",
        meaning="number of marker rows about the middle of a tube; requires --around and --pitch",
        ge=1,
        le=200,
    )
    around: int | None = parameter(None, unit="1", meaning="markers per row, from azimuth 0", ge=3, le=500)
    pitch: float | None = parameter(None, unit="mm", meaning="distance between rows along the meridian", gt=0, le=200)
    file: Path | None = parameter(
        None,
        unit="",
        meaning="free layout: a table with the columns x_mm, y_mm and optionally z_mm, or a drawing (DXF, SVG) with "
        "a circle per marker",
        flag="layout",
    )
    diameter: float = parameter(
        1.5,
        unit="mm",
        meaning="diameter of a marker",
        source="measured in published images",
        flag="marker-diameter",
        gt=0,
        le=10,
    )

    @model_validator(mode="before")
    @classmethod
    def _count_follows_the_layout(cls, values: Any) -> Any:
        if not isinstance(values, dict):
            return values
        rings, given = values.get("ring_diameters"), [name for name in _ROWS if values.get(name) is not None]
        if given and (len(given) < len(_ROWS) or rings is not None or values.get("file") is not None):
            raise PydanticCustomError(
                "rows-not-alone",
                "rows, around and pitch must be given together, without ring_diameters and file.",
                {},
            )
        if "count" in values:
            return values
        numbers = [str(values.get(name)) for name in ("rows", "around")]
        if given and all(number.isdigit() for number in numbers):
            return {**values, "count": int(numbers[0]) * int(numbers[1])}
        return {**values, "count": markers_in_rings(len(rings))} if isinstance(rings, list | tuple) else values

    @model_serializer(mode="wrap")
    def _leave_out_rows(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out absent rows, so that older artefacts keep their keys."""
        content: dict[str, Any] = dump(self)
        return {name: value for name, value in content.items() if name not in _ROWS or value is not None}

    @field_validator("ring_diameters")
    @classmethod
    def _rings_grow(cls, rings: tuple[float, ...] | None) -> tuple[float, ...] | None:
        if rings is not None and not all(a < b for a, b in zip((0.0, *rings), rings, strict=False)):
            raise PydanticCustomError(
                "rings-not-growing",
                "ring diameters {rings} mm are not positive and ascending; list them from the apex outward.",
                {"rings": ", ".join(f"{ring:g}" for ring in rings)},
            )
        return rings

    @model_validator(mode="after")
    def _count_is_a_ring_number(self) -> MarkerSpec:
        if self.file is not None:
            if self.ring_diameters is not None:
                raise PydanticCustomError(
                    "layout-twice", "ring_diameters and file exclude each other; keep one of them.", {}
                )
            return self
        if self.rows is not None and self.around is not None:
            if self.count != self.rows * self.around:
                raise PydanticCustomError(
                    "marker-count-differs",
                    "{rows} rows of {around} markers are not {count}; leave count out.",
                    {"rows": self.rows, "around": self.around, "count": self.count},
                )
            return self
        rings = ring_count(self.count)
        if rings is None:
            below = max(n for n in range(MAX_RINGS + 1) if markers_in_rings(n) < self.count)
            nearest = " or ".join(str(markers_in_rings(n)) for n in (below, below + 1) if n <= MAX_RINGS)
            raise PydanticCustomError(
                "marker-count-not-rings",
                "count {count} is not 1 + 3 n (n + 1) for up to {rings} rings; nearest valid: {nearest}.",
                {"count": self.count, "rings": MAX_RINGS, "nearest": nearest},
            )
        if self.ring_diameters is not None and len(self.ring_diameters) != rings:
            raise PydanticCustomError(
                "marker-count-differs",
                "{given} ring diameters make {made} markers, but count is {count}; leave count out.",
                {
                    "given": len(self.ring_diameters),
                    "made": markers_in_rings(len(self.ring_diameters)),
                    "count": self.count,
                },
            )
        return self
