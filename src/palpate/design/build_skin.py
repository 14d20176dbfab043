"""Skins by name, and from a spec to a skin."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from palpate.core import PalpateError, Registry
from palpate.design.skin import Skin
from palpate.design.spec import SkinSpec

SKINS: Registry[type[SkinSpec]] = Registry(
    "palpate.skins",
    "skin",
    {"dome": "palpate.design.dome:DomeSpec", "ellipsoid": "palpate.design.ellipsoid:EllipsoidSpec"},
    lambda found: isinstance(found, type) and issubclass(found, SkinSpec),
)
"""Skin specs by their `kind`."""


def build_skin(spec: SkinSpec) -> Skin:
    """Build the skin of `spec`.

    Examples
    --------
    >>> from palpate.design import DomeSpec
    >>> skin = build_skin(DomeSpec(height=30))
    >>> round(skin.radius, 2), skin.shape
    (21.67, 'spherical cap')
    """
    return spec.build()


def skin_from_data(data: Mapping[str, Any]) -> SkinSpec:
    """Read a skin's spec from plain values; without a ``kind`` it is a dome.

    Raises
    ------
    PalpateError
        If there is no skin of that kind, or a number is missing, unknown or out of bounds.
    """
    kind = SKINS.get(str(data.get("kind", "dome")))
    own = data if "kind" in kind.model_fields else {name: value for name, value in data.items() if name != "kind"}
    try:
        return kind.model_validate(dict(own))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise PalpateError(
            f"The skin's {where or 'numbers'}: {first['msg']}.",
            f"Its numbers are {', '.join(name for name in kind.model_fields if name != 'kind')}.",
        ) from None


def read_skin(text: str, sizes: SkinSpec) -> SkinSpec:
    """Read a skin from words, ``KIND`` or ``KIND:NAME=VALUE,…``, with the sizes of a spec.

    Raises
    ------
    PalpateError
        If it is not written so, or is no skin.

    Examples
    --------
    >>> from palpate.design import DomeSpec
    >>> read_skin("ellipsoid:aspect=0.8", DomeSpec(height=15)).build().name
    'ellipsoid 0.8 H15 T2'
    """
    kind, _, rest = text.partition(":")
    pairs = [item.partition("=") for item in rest.split(",") if item]
    if any(not mark or not name for name, mark, _ in pairs):
        raise PalpateError(f"The skin '{text}' is not written as KIND:NAME=VALUE.", "Write ellipsoid:aspect=0.8.")
    own = {name: getattr(sizes, name) for name in ("height", "base_radius", "thickness")}
    return skin_from_data({"kind": kind, **own, **{name.strip(): value for name, _, value in pairs}})
