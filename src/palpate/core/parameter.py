"""Parameters declared once: default, unit, bounds, meaning and source at one field.

A *spec* is a frozen record of the choices of a user. Its fields are declared by `parameter`; validation, command-line
help and the tables of the documentation are derived from this declaration.

    >>> class HoleSpec(Spec):
    ...     diameter: float = parameter(6.0, unit="mm", meaning="bore", gt=0, le=20)
    >>> HoleSpec(diameter="8 mm").diameter
    8.0
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, get_args

from pydantic import BaseModel, ConfigDict, Field, ValidationError, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from palpate.core.renamed_keys import RENAMED_KEYS
from palpate.core.spec_error import SpecError, describe_value

_QUANTITY = re.compile(r"^\s*((?>[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?))\s*([^\d\s].*?)\s*$")
"""A complete number followed by a unit; a number alone does not match."""


def parameter(
    default: Any,
    *,
    unit: str,
    meaning: str,
    source: str = "",
    flag: str = "",
    **bounds: float,
) -> Any:
    """Declare one parameter of a spec.

    Parameters
    ----------
    default
        Default value; `...` makes the parameter required.
    unit
        Unit of the value as printed ("mm", "deg", "px", "MPa", "1" for a pure number).
    meaning
        One phrase for help texts and documentation.
    source
        Source of the default, if it is not our own choice.
    flag
        Name on the command line without dashes, if it is not derived from the field's (`flag_name`).
    **bounds
        Any of `gt`, `ge`, `lt`, `le`, in the same unit.
    """
    extra: dict[str, Any] = {"unit": unit, "source": source, "meaning": meaning, "flag": flag}
    limits = ", ".join(f"{_SIGNS[name]} {value:g}" for name, value in bounds.items())
    inside = "; ".join(part for part in (unit if unit != "1" else "", limits) if part)
    help_text = f"{meaning[:1].upper()}{meaning[1:]}" + (f" ({inside})." if inside else ".")
    return Field(default, description=help_text, json_schema_extra=extra, **bounds)  # type: ignore[call-overload]


_SIGNS = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
_UNIT_ENDINGS = ("_deg", "_px", "_percent")


if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)


class _SpecType(ModelMetaclass):
    """Type of specs: a call with wrong values raises a `SpecError`."""

    if not TYPE_CHECKING:  # type checkers see the fields of each spec

        def __call__(self, *args: Any, **values: Any) -> Any:
            try:
                return super().__call__(*args, **values)
            except ValidationError as error:
                raise SpecError.from_validation(error, self) from None


class Spec(BaseModel, metaclass=_SpecType):
    """Choices of a user for one stage: frozen, unknown keys rejected, units checked.

    A field with a unit accepts a number or a text such as ``"2 mm"``; any other unit is rejected, and so is a number
    that is not finite. An empty text is read as `None` if the field allows it.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    describe_value = staticmethod(describe_value)

    @model_validator(mode="before")
    @classmethod
    def _refuse_old_keys(cls, data: Any) -> Any:
        for name in data if isinstance(data, Mapping) else ():
            for kind in cls.__mro__:
                new = RENAMED_KEYS.get(kind.__name__, {}).get(name)
                if new is not None and name not in cls.model_fields:
                    raise PydanticCustomError("yaml-key-renamed", "{old} is {new} now", {"old": name, "new": new})
        return data

    @field_validator("*", mode="before")
    @classmethod
    def _strip_unit(cls, value: Any, info: ValidationInfo) -> Any:
        field = cls.model_fields[info.field_name or ""]
        if isinstance(value, str) and value == "" and type(None) in get_args(field.annotation):
            return None
        return _without_unit(cls, info.field_name or "", value)


@dataclass(frozen=True)
class ParameterDoc:
    """One row of a table of parameters, from the declaration of a field.

    Attributes
    ----------
    name, meaning, unit, source
        As declared; `unit` is empty for a field without one.
    help
        Meaning, unit and bounds in one sentence, e.g. ``"Bore (mm; > 0, <= 20)."``: help of the flag.
    default
        Default value, or `None` for a required field.
    bounds
        Bounds as printed, e.g. ``"> 0, <= 20"``; may be empty.
    """

    name: str
    meaning: str
    unit: str
    default: Any
    bounds: str
    source: str
    help: str


def parameters(spec: type[BaseModel]) -> tuple[ParameterDoc, ...]:
    """Describe every field of `spec`, in the order of declaration.

    Examples
    --------
    >>> class HoleSpec(Spec):
    ...     diameter: float = parameter(6.0, unit="mm", meaning="bore", gt=0, le=20)
    >>> parameters(HoleSpec)[0].help
    'Bore (mm; > 0, <= 20).'
    """
    notes = []
    for name, field in spec.model_fields.items():
        extra = _declared(spec, name)
        bounds = [
            f"{sign} {getattr(item, bound):g}"
            for item in field.metadata
            for bound, sign in _SIGNS.items()
            if getattr(item, bound, None) is not None
        ]
        notes.append(
            ParameterDoc(
                name=name,
                meaning=str(extra.get("meaning", "")),
                unit=str(extra.get("unit", "")),
                default=None if field.is_required() else field.get_default(call_default_factory=True),
                bounds=", ".join(bounds),
                source=str(extra.get("source", "")),
                help=field.description or "",
            )
        )
    return tuple(notes)


def flag_name(spec: type[BaseModel], name: str) -> str:
    """Return the name of a field on the command line: its declared flag, or its name without the unit.

    Examples
    --------
    >>> class HoleSpec(Spec):
    ...     depth_deg: float = parameter(30.0, unit="deg", meaning="slope")
    >>> flag_name(HoleSpec, "depth_deg")
    'depth'
    """
    declared = str(_declared(spec, name).get("flag", ""))
    ending = next((ending for ending in _UNIT_ENDINGS if name.endswith(ending)), "")
    return declared or name.removesuffix(ending).replace("_", "-").lower()


def _declared(spec: type[BaseModel], name: str) -> dict[str, Any]:
    """Return the declaration of a field by `parameter`; empty for other fields."""
    field = spec.model_fields.get(name)
    extra = field.json_schema_extra if field is not None else None
    return dict(extra) if isinstance(extra, dict) else {}


def _without_unit(spec: type[Spec], name: str, value: Any) -> Any:
    extra = _declared(spec, name)
    if not extra.get("unit"):  # a text, such as a name, is no quantity
        return value
    if isinstance(value, list | tuple):
        return [_without_unit(spec, name, item) for item in value]
    match = _QUANTITY.match(value) if isinstance(value, str) else None
    if match is None:
        return value
    number, unit = match.groups()
    if unit != extra["unit"]:
        raise PydanticCustomError(
            "quantity-unit-wrong",
            "{name} is given in {given}, but its unit is {unit}. Write the number in {unit}.",
            {"name": name, "given": unit, "unit": str(extra["unit"])},
        )
    return float(number)
