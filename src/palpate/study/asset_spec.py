"""Configuration of the asset of a sensor for a simulator."""

from __future__ import annotations

import re
from enum import StrEnum

from pydantic import field_validator
from pydantic_core import PydanticCustomError

from palpate.core import Spec, parameter


class AssetFormat(StrEnum):
    """Language that an asset is written in."""

    MJCF = "mjcf"
    URDF = "urdf"
    USD = "usd"


class AssetSpec(Spec):
    """Parameters of a simulator asset that presses do not determine: name, density, friction and damping."""

    name: str | None = parameter(
        None,
        unit="",
        meaning="beginning of the names of all links, joints, meshes and cameras, such as left_finger; empty: "
        "palpate_ and the skin",
    )
    density: float = parameter(
        1070.0,
        unit="kg/m3",
        meaning="density of the cured elastomer, and of a gel inside",
        source="Smooth-On technical bulletin, Ecoflex series: specific gravity of Ecoflex 00-30",
        ge=100,
        le=5000,
    )
    friction: float = parameter(
        1.0, unit="1", meaning="coefficient of friction of the asset's contacts", ge=0, le=10, flag="asset-friction"
    )
    damping_ratio: float = parameter(
        1.0, unit="1", meaning="contact damping over the critical damping of the skin's mass", ge=0, le=10
    )

    @field_validator("name")
    @classmethod
    def _name_is_an_identifier(cls, name: str | None) -> str | None:
        if name is not None and not re.fullmatch(r"(?!world$)[A-Za-z_][A-Za-z0-9_]*", name):
            raise PydanticCustomError(
                "name-not-identifier",
                "'{name}' is not a name in all formats; use letters, digits and _, such as left_finger.",
                {"name": name},
            )
        return name
