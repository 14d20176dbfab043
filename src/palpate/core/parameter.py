"""Declare each number once: default, unit, bounds, meaning and source stand at one field.

A *spec* is a frozen record of what a person may choose. Its fields are declared by `parameter`; validation,
command-line help and the tables of the documentation are all read from that one place.

    >>> class HoleSpec(Spec):
    ...     diameter: float = parameter(6.0, unit="mm", meaning="bore", gt=0, le=20)
    >>> HoleSpec(diameter="8 mm").diameter
    8.0
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel, ConfigDict, Field, ValidationInfo, field_validator
from pydantic_core import PydanticCustomError

_QUANTITY = re.compile(r"^\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([^\d\s].*?)\s*$")


def parameter(
    default: Any,
    *,
    unit: str,
    meaning: str,
    source: str = "",
    **bounds: float,
) -> Any:
    """Declare one number of a spec.

    Parameters
    ----------
    default
        Value used when nothing is chosen; `...` makes the parameter required.
    unit
        Unit of the value as printed ("mm", "deg", "px", "MPa", "1" for a pure number).
    meaning
        One phrase for help texts and documentation.
    source
        Where the default comes from, if it is not our own choice.
    **bounds
        Any of `gt`, `ge`, `lt`, `le`, in the same unit.
    """
    extra: dict[str, Any] = {"unit": unit, "source": source}
    return Field(default, description=meaning, json_schema_extra=extra, **bounds)  # type: ignore[call-overload]


class Spec(BaseModel):
    """What a person may choose for one stage: frozen, unknown keys refused, units checked.

    A field with a unit accepts a number or a text such as ``"2 mm"``; any other unit is refused.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    @field_validator("*", mode="before")
    @classmethod
    def _strip_unit(cls, value: Any, info: ValidationInfo) -> Any:
        return _without_unit(cls, info.field_name or "", value)


@dataclass(frozen=True)
class ParameterNote:
    """One row of a table of parameters, read from the field that declares it.

    Attributes
    ----------
    name, meaning, unit, source
        As declared; `unit` is empty for a field without one.
    default
        Value used when nothing is chosen, or `None` for a required field.
    bounds
        Bounds as printed, e.g. ``"> 0, <= 20"``; empty where there are none.
    """

    name: str
    meaning: str
    unit: str
    default: Any
    bounds: str
    source: str

    def help(self) -> str:
        """One line for a command's help: meaning, unit and bounds, e.g. ``"bore (mm; > 0, <= 20)"``."""
        unit = "" if self.unit == "1" else self.unit
        inside = "; ".join(part for part in (unit, self.bounds) if part)
        return f"{self.meaning} ({inside})" if inside else self.meaning


_SIGNS = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}


def parameters(spec: type[BaseModel]) -> tuple[ParameterNote, ...]:
    """Describe every field of `spec`, in the order of declaration."""
    notes = []
    for name, field in spec.model_fields.items():
        extra = field.json_schema_extra
        extra = extra if isinstance(extra, dict) else {}
        bounds = [
            f"{sign} {getattr(item, bound):g}"
            for item in field.metadata
            for bound, sign in _SIGNS.items()
            if getattr(item, bound, None) is not None
        ]
        notes.append(
            ParameterNote(
                name=name,
                meaning=field.description or "",
                unit=str(extra.get("unit", "")),
                default=None if field.is_required() else field.get_default(call_default_factory=True),
                bounds=", ".join(bounds),
                source=str(extra.get("source", "")),
            )
        )
    return tuple(notes)


def _without_unit(spec: type[Spec], name: str, value: Any) -> Any:
    field = spec.model_fields.get(name)
    extra = field.json_schema_extra if field is not None else None
    if not isinstance(extra, dict) or "unit" not in extra:
        return value
    if isinstance(value, list | tuple):
        return [_without_unit(spec, name, item) for item in value]
    match = _QUANTITY.match(value) if isinstance(value, str) else None
    if match is None:
        return value
    number, unit = match.groups()
    if unit != extra["unit"]:
        raise PydanticCustomError(
            "wrong_unit",
            "{name} is given in {given}, but its unit is {unit}. Write the number in {unit}.",
            {"name": name, "given": unit, "unit": str(extra["unit"])},
        )
    return float(number)
