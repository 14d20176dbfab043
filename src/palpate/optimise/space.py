"""Search space of skins: its variables, and the skin at a place in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from palpate.design import SkinSpec, skin_from_data
from palpate.optimise.spec import FIELDS, RequirementsSpec

_GRAIN = {"height": 0.1, "base_radius": 0.1, "thickness": 0.05, "aspect": 0.02, "taper": 0.05}
"""Rounding steps of a drawing, mm, and of the ratios. By hand."""
Place = Mapping[str, float | str]


@dataclass(frozen=True)
class SkinSpace:
    """Variables of a search, with their ranges.

    Attributes
    ----------
    ranges
        Minimum and maximum of every searched number.
    fixed
        Numbers common to all skins.
    materials
        Elastomers to choose from.
    """

    ranges: Mapping[str, tuple[float, float]]
    fixed: Mapping[str, float]
    materials: tuple[str, ...]

    @classmethod
    def of(cls, spec: RequirementsSpec) -> SkinSpace:
        """Return the space that requirements leave open."""
        given: dict[str, tuple[float, float]] = {name: getattr(spec, field) for field, name in FIELDS.items()}
        open_ = {name: ends for name, ends in given.items() if ends[1] - ends[0] >= _GRAIN[name]}
        fixed = {name: ends[0] for name, ends in given.items() if name not in open_}
        return cls(open_, fixed, spec.materials)

    def skin(self, place: Place) -> SkinSpec:
        """Return the skin at a place, rounded to feasible steps; a dome if aspect and taper are 1."""
        numbers = {**self.fixed, **{name: _round(name, float(place[name])) for name in self.ranges}}
        ratios = {name: numbers.pop(name, 1.0) for name in ("aspect", "taper")}
        shape = {} if set(ratios.values()) == {1.0} else {"kind": "ellipsoid", **ratios}
        return skin_from_data({**shape, **numbers})

    def material(self, place: Place) -> str:
        """Return the elastomer at a place."""
        return str(place.get("material", self.materials[0]))

    def place(self, skin: SkinSpec) -> Place:
        """Return the place nearest to a skin."""
        numbers = {"aspect": 1.0, "taper": 1.0, **skin.model_dump()}
        found = {name: min(max(float(numbers[name]), low), high) for name, (low, high) in self.ranges.items()}
        return {**found, "material": self.materials[0]} if len(self.materials) > 1 else found


def _round(name: str, value: float) -> float:
    return round(round(value / _GRAIN[name]) * _GRAIN[name], 6)
