"""Specs chosen by kind from a registry, from plain values or from a text."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from pydantic import ValidationError

from palpate.core.errors import PalpateError
from palpate.core.parameter import Spec
from palpate.core.registry import Registry
from palpate.core.spec_error import describe_value

S = TypeVar("S", bound=Spec)


def spec_from_data(kinds: Registry[type[S]], data: Mapping[str, Any], oldest: str) -> S:
    """Build a spec from plain values.

    Parameters
    ----------
    kinds
        Specs by kind.
    data
        Values of its fields, and its ``kind``.
    oldest
        Kind of values without one, whose spec has no field for it.

    Raises
    ------
    PalpateError
        If the kind is unknown, or a value is missing, unknown or out of bounds.
    """
    kind = kinds.get(str(data.get("kind", oldest)))
    own = {name: value for name, value in data.items() if name != "kind" or "kind" in kind.model_fields}
    try:
        return kind.model_validate(own)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        name = f"The {kinds.noun}'s {where or 'numbers'}"
        raise PalpateError(
            f"{describe_value(first, name)}.",
            f"Its parameters are {', '.join(name for name in kind.model_fields if name != 'kind')}.",
            code=first["type"],
        ) from None


def data_from_text(noun: str, text: str) -> dict[str, Any]:
    """Return the plain values of a text ``KIND`` or ``KIND:NAME=VALUE,…``.

    Raises
    ------
    PalpateError
        If the text has another form.

    Examples
    --------
    >>> data_from_text("obstacle", "ball:radius=8,offset=2")
    {'kind': 'ball', 'radius': '8', 'offset': '2'}
    """
    kind, _, rest = text.partition(":")
    pairs = [item.partition("=") for item in rest.split(",") if item]
    if any(not mark or not name for name, mark, _ in pairs):
        raise PalpateError(
            f"The {noun} '{text}' is not written as KIND:NAME=VALUE.",
            f"Write {kind}:NAME=VALUE.",
            code="kind-malformed",
        )
    return {"kind": kind, **{name.strip(): value for name, _, value in pairs}}
