"""Flags read from specs: type, meaning, unit, bounds and default are declared once, at the field."""

from __future__ import annotations

from enum import Enum
from typing import get_args

from cyclopts import Group, Parameter, default_name_transform
from pydantic import BaseModel

from palpate.core import flag_name


def flags_of(spec: type[BaseModel], *, only: str = "", without: str = "", group: str | None = None) -> Parameter:
    """Make every field of a spec a flag of the command whose argument is annotated with the result.

    Parameters
    ----------
    spec
        The spec; `palpate.core.flag_name` names its flags.
    only, without
        Names of fields, separated by spaces: the only fields that become flags, or fields that do not.
    group
        Heading of the flags in the help; `None` for the heading of the command's own parameters.
    """
    kinds = [field.annotation for field in spec.model_fields.values()]
    choices = {
        member.name: str(member.value)
        for kind in (part for kind in kinds for part in (kind, *get_args(kind)))
        if isinstance(kind, type) and issubclass(kind, Enum)
        for member in kind
    }

    def transform(name: str) -> str:
        """Return the flag of a field, or the value of an enum's member, which the spec reads."""
        if name in spec.model_fields:
            return flag_name(spec, name)
        return choices.get(name) or default_name_transform(name)

    left_out = [name for name in spec.model_fields if name in without.split() or (only and name not in only.split())]
    return Parameter(
        name="*",
        name_transform=transform,
        parse=rf"^(?!({'|'.join(left_out)})$)" if left_out else None,  # read against the field's own name
        negative_iterable=(),
        consume_multiple=True,
        group=Group.create_ordered(group) if group else Group.create_default_parameters(),
    )
