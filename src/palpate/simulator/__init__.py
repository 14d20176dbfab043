"""Simulator: a sensor as an asset of MuJoCo, of URDF or of USD: mesh, mass, camera, frames and how it yields."""

from palpate.simulator.asset import OPTICAL_FROM_BODY, SensorAsset, build_asset, check_wall
from palpate.simulator.export_asset import check_asset, describe_asset, export_asset
from palpate.simulator.mass import MassProperties, weigh
from palpate.simulator.shell import skin_surface
from palpate.simulator.spec import AssetFormat, AssetSpec

__all__ = [
    "OPTICAL_FROM_BODY",
    "AssetFormat",
    "AssetSpec",
    "MassProperties",
    "SensorAsset",
    "build_asset",
    "check_asset",
    "check_wall",
    "describe_asset",
    "export_asset",
    "skin_surface",
    "weigh",
]
