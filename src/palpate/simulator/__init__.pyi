"""Simulator: a sensor as an asset of MuJoCo, of URDF or of USD: mesh, mass, camera, frames and how it yields."""

from palpate.simulator.asset import OPTICAL_FROM_BODY, SensorAsset, build_asset, check_force_curve_press
from palpate.simulator.export_asset import check_asset, describe_asset, export_asset
from palpate.simulator.mass import MassProperties, compute_mass_properties
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
    "check_force_curve_press",
    "compute_mass_properties",
    "describe_asset",
    "export_asset",
    "skin_surface",
]
