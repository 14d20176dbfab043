"""Registry of skins, and their construction from specs and texts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from palpate.core import Registry, data_from_text, spec_from_data
from palpate.design.skin import Skin
from palpate.design.spec import SkinSpec

SKINS: Registry[type[SkinSpec]] = Registry(
    "palpate.skins",
    "skin",
    {
        "dome": "palpate.design.dome:DomeSpec",
        "ellipsoid": "palpate.design.ellipsoid:EllipsoidSpec",
        "cone": "palpate.design.cone:ConeSpec",
        "spline": "palpate.design.spline:SplineSpec",
        "pinned": "palpate.design.pinned:PinnedSpec",
        "pad": "palpate.design.flat_pad:FlatPadSpec",
        "barrel": "palpate.design.barrel:BarrelSpec",
    },
    lambda found: isinstance(found, type) and issubclass(found, SkinSpec),
)
"""Skin specs by their `kind`."""


def build_skin(spec: SkinSpec) -> Skin:
    """Build the skin of `spec`.

    Examples
    --------
    >>> from palpate.design import DomeSpec
    >>> skin = build_skin(DomeSpec(height=30))
    >>> round(skin.radius, 2), str(skin.shape)
    (21.67, 'spherical cap')
    """
    return spec.build()


def skin_from_data(data: Mapping[str, Any]) -> SkinSpec:
    """Read a skin's spec from plain values; without a ``kind``, it is a dome.

    The kind ``profile`` reads a drawn meridian (`read_profile`).

    Raises
    ------
    PalpateError
        If the kind is unknown, or a parameter is missing, unknown or out of bounds.
    """
    if data.get("kind") == "profile":
        from palpate.design.profile import profile_data  # scipy takes a second, and other kinds do not need it

        data = profile_data(data)
    return spec_from_data(SKINS, data, "dome")


def read_skin(text: str, sizes: SkinSpec) -> SkinSpec:
    """Read a skin spec from a text ``KIND`` or ``KIND:NAME=VALUE,…``, with the sizes of a spec.

    Raises
    ------
    PalpateError
        If the text has another form, or no skin has these dimensions.

    Examples
    --------
    >>> from palpate.design import DomeSpec
    >>> read_skin("ellipsoid:aspect=0.8", DomeSpec(height=15)).build().name
    'ellipsoid 0.8 H15 T2'
    """
    own = {name: getattr(sizes, name) for name in SkinSpec.model_fields}
    return skin_from_data(own | data_from_text("skin", text))
