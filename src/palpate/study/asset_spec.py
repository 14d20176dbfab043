"""Configuration of the asset of a sensor for a simulator."""

from __future__ import annotations

from enum import StrEnum

from palpate.core import Spec, parameter


class AssetFormat(StrEnum):
    """Language that an asset is written in."""

    MJCF = "mjcf"
    URDF = "urdf"
    USD = "usd"


class AssetSpec(Spec):
    """Parameters of a simulator asset that presses do not determine: density, friction and damping."""

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
