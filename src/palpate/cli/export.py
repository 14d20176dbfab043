"""`palpate design export`: a sensor as an asset of a simulator."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from palpate.camera import CameraSpec, read_calibration
from palpate.cli.compiling import announce_compilation
from palpate.cli.flag import flags_of
from palpate.cli.output import JsonOutput
from palpate.cli.unit import MaterialFlags, SkinFlags
from palpate.fea import WallSpec
from palpate.mesh import MeshSpec
from palpate.study import AssetFormat, AssetSpec, MaterialSpec

_TO = "Format: mjcf (MuJoCo), urdf (with contact parameters of Gazebo), or usd (with UsdPhysics)."
_OUT = "New folder for the asset."
_LENS = "YAML file of `palpate calibration camera`; without it, the nominal camera's lens."


@Parameter(name="*")
@dataclass(frozen=True)
class AssetFlags:
    """Skin, material, mesh, press, asset and lens of an export."""

    shape: SkinFlags = SkinFlags()
    material: MaterialFlags = MaterialSpec()
    mesh: Annotated[MeshSpec, flags_of(MeshSpec, only="cells", group="Mesh")] = MeshSpec()
    wall: Annotated[WallSpec, flags_of(WallSpec, only="depth depth_step contact", group="Wall")] = WallSpec()
    spec: Annotated[AssetSpec, flags_of(AssetSpec, group="Asset")] = AssetSpec()
    lens: Annotated[Path | None, Parameter(help=_LENS)] = None


def export(
    *,
    to: Annotated[AssetFormat, Parameter(help=_TO)],
    out: Annotated[Path, Parameter(name=("--out", "-o"), help=_OUT)],
    flags: AssetFlags = AssetFlags(),
    output: JsonOutput = JsonOutput(),
) -> None:
    """Write a sensor as an asset: mesh, mass, camera, frames, and stiffness from a press."""
    from palpate.camera import build_camera
    from palpate.fea import solve_press
    from palpate.mesh import mesh_skin
    from palpate.study import build_asset, check_asset, check_force_curve_press, describe_asset, export_asset

    check_asset(out)
    check_force_curve_press(flags.wall)
    lens = read_calibration(flags.lens).camera_spec() if flags.lens else CameraSpec()
    mesh = mesh_skin(flags.shape.skin_spec().build(), flags.material.mesh(flags.mesh))
    announce_compilation()
    press = solve_press(mesh, flags.material.material(), flags.wall)
    asset = build_asset(press, build_camera(lens), flags.spec)
    path = export_asset(out, asset, to)
    centre = asset.body.centre_mm[2]
    output.show(
        {"file": str(path), **describe_asset(asset)},
        f"{path}: mass {1e3 * asset.body.mass_kg:.3f} g, centre of mass {centre:.2f} mm above the base; stiffness "
        f"{asset.stiffness:.1f} N/m up to {1e3 * asset.reach:.1f} mm (RMS residual {1e3 * asset.stiffness_rms:.0f} "
        f"mN), force curve with RMS residual {1e3 * asset.spring_rms:.1f} mN",
    )
