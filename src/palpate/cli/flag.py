"""Flags read from specs: meaning, unit, bounds and default are declared once, at the field."""

from __future__ import annotations

from typing import Annotated, Any

from cyclopts import Parameter
from pydantic import BaseModel

from palpate.core import parameters

JsonFlag = Annotated[bool, Parameter(name="--json", negative="", help="Print JSON, and only JSON.")]
"""`--json` of every command."""


def flag(spec: type[BaseModel], name: str, *names: str) -> Parameter:
    """A flag that carries the meaning, unit and bounds of a spec's field.

    Parameters
    ----------
    spec, name
        The spec and its field.
    *names
        Names of the flag, if they are not that of the variable.
    """
    note = next(note for note in parameters(spec) if note.name == name)
    text = f"{note.help()[:1].upper()}{note.help()[1:]}."
    return Parameter(name=names or None, help=text, negative="", consume_multiple=True)


def default(spec: type[BaseModel], name: str) -> Any:
    """Default of a spec's field."""
    return spec.model_fields[name].get_default(call_default_factory=True)
