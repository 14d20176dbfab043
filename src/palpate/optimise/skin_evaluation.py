"""Evaluation of a skin: its layouts with camera, and the predicted accuracy of its units."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from palpate.calibration import PredictedAccuracy
from palpate.design import MarkerSpec, SkinSpec, skin_from_data


@dataclass(frozen=True)
class LayoutOption:
    """Markers and camera on one skin, with the predicted accuracy.

    Attributes
    ----------
    markers
        The chosen rings.
    camera, distance, price
        Name of the camera, its distance below the base plane (mm), and its price.
    accuracy
        Predicted accuracy of units, after the required number of calibration presses.
    """

    markers: MarkerSpec
    camera: str
    distance: float
    price: float
    accuracy: PredictedAccuracy


@dataclass(frozen=True)
class SkinEvaluation:
    """Evaluation of one skin.

    Attributes
    ----------
    skin, material
        The skin.
    max_depth_mm
        Maximum depth on the flat branch under every tilt and friction.
    force_n
        Maximum force of any press, N.
    bistable_from_mm
        Depth from which a straight press has an inverted state; `None` if none was found or it was not examined.
    options
        Best layout and camera of each number of markers; empty if there is a problem.
    problem
        Reason why the skin cannot be used.
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
        """Maximum outer diameter."""
        skin = self.skin.build()
        return 2.0 * (skin.widest[0] + skin.thickness)

    def best(self, most: int) -> LayoutOption | None:
        """Return the option of minimum error with at most `most` markers."""
        fit = [option for option in self.options if option.markers.count <= most]
        return min(fit, key=lambda option: option.accuracy.p95_deg, default=None)

    def to_data(self) -> dict[str, Any]:
        """Return the evaluation as JSON data."""
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
        """Build an evaluation from the data of `to_data`."""
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
