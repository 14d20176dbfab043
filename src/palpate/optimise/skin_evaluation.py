"""The proposal: a skin with its markers and camera, and what units of it will be."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from palpate.calibration import PredictedAccuracy
from palpate.design import MarkerSpec, SkinSpec, skin_from_data


@dataclass(frozen=True)
class LayoutOption:
    """Markers and camera on one skin, and what units of it will be.

    Attributes
    ----------
    markers
        The rings that were chosen.
    camera, distance, price
        Name of the camera, its distance below the base plane (mm), and its price.
    accuracy
        What is foreseen of built units, at the requirements' number of known presses.
    """

    markers: MarkerSpec
    camera: str
    distance: float
    price: float
    accuracy: PredictedAccuracy


@dataclass(frozen=True)
class SkinEvaluation:
    """What is known of one skin.

    Attributes
    ----------
    skin, material
        The skin.
    max_depth_mm
        Depth to which it can be pressed on its flat branch under every tilt and friction.
    force_n
        Greatest force in any press, N.
    bistable_from_mm
        Depth from which it has a second, inverted state when pressed straight; `None`: none found, or not asked.
    options
        Markers and cameras, best of their number; empty where there is a problem.
    problem
        Why the skin cannot be used.
    """

    skin: SkinSpec
    material: str
    max_depth_mm: float = 0.0
    force_n: float = 0.0
    bistable_from_mm: float | None = None
    options: tuple[LayoutOption, ...] = ()
    problem: str = ""

    @property
    def size_mm(self) -> float:
        """Outer diameter at the base or where it is widest."""
        skin = self.skin.build()
        return 2.0 * (skin.widest[0] + skin.thickness)

    def best(self, most: int) -> LayoutOption | None:
        """The option of least error among those of at most so many markers."""
        fit = [option for option in self.options if option.markers.count <= most]
        return min(fit, key=lambda option: option.accuracy.p95_deg, default=None)

    def to_data(self) -> dict[str, Any]:
        """As JSON holds it."""
        return {
            "skin": dict(self.skin.build().spec_data),
            "material": self.material,
            "max_depth_mm": self.max_depth_mm,
            "force_n": self.force_n,
            "bistable_from_mm": self.bistable_from_mm,
            "options": [_option_data(option) for option in self.options],
            "problem": self.problem,
        }

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> SkinEvaluation:
        """From what `to_data` gave."""
        return cls(**{**data, "skin": skin_from_data(data["skin"]), "options": tuple(_options_from(data["options"]))})


def _option_data(option: LayoutOption) -> dict[str, Any]:
    figure = option.accuracy
    return {
        "ring_diameters_mm": list(option.markers.ring_diameters or ()),
        "marker_diameter_mm": option.markers.diameter,
        "camera": option.camera,
        "distance": option.distance,
        "price": option.price,
        **{f"figure_{name}": getattr(figure, name) for name in PredictedAccuracy.__dataclass_fields__},
    }


def _options_from(rows: Iterable[Mapping[str, Any]]) -> Iterable[LayoutOption]:
    for row in rows:
        markers = MarkerSpec.model_validate(
            {"ring_diameters": list(row["ring_diameters_mm"]), "diameter": row["marker_diameter_mm"]}
        )
        figure = PredictedAccuracy(**{name: row[f"figure_{name}"] for name in PredictedAccuracy.__dataclass_fields__})
        yield LayoutOption(markers, row["camera"], row["distance"], row["price"], figure)
