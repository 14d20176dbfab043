"""Export of a sensor asset: a new folder with the simulator's file, the mesh, and its numbers as JSON."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from palpate.core import PalpateError, atomic_folder, load_extra, provenance
from palpate.fabrication import write_mesh
from palpate.study.asset import SensorAsset
from palpate.study.asset_spec import AssetFormat
from palpate.study.mjcf import mjcf_text
from palpate.study.urdf import urdf_text
from palpate.study.usd import usd_text

_FILES = {
    AssetFormat.MJCF: ("sensor.xml", mjcf_text),
    AssetFormat.URDF: ("sensor.urdf", urdf_text),
    AssetFormat.USD: ("sensor.usda", usd_text),
}


def check_asset(folder: Path) -> None:
    """Reject an asset that cannot be written, before anything is solved.

    Raises
    ------
    PalpateError
        If the folder exists, or its parent does not.
    MissingExtraError
        If trimesh, which writes the mesh, is not installed.
    """
    load_extra("trimesh", "cad")
    if folder.exists():
        raise PalpateError(
            f"{folder} exists already.", "Name a new folder, or remove that one.", code="folder-exists"
        )
    if not folder.parent.is_dir():
        raise PalpateError(
            f"The folder {folder.parent} does not exist.",
            "Make it first, or name another one.",
            code="folder-missing",
        )


def export_asset(folder: Path, asset: SensorAsset, to: AssetFormat) -> Path:
    """Write an asset to a new folder atomically; return the file for the simulator.

    Raises
    ------
    PalpateError
        As `check_asset`, or if the folder cannot be written.
    """
    check_asset(folder)
    name, text = _FILES[to]
    with atomic_folder(folder, "Name another folder.") as draft:
        mesh = f"{asset.name}_skin.stl"  # binary, in mm; of another name for each sensor of a robot
        (draft / name).write_text(text(asset, mesh), encoding="utf-8")
        write_mesh(draft / mesh, asset.surface)
        (draft / "asset.json").write_text(json.dumps(describe_asset(asset), indent=2) + "\n", encoding="utf-8")
    return folder / name


def describe_asset(asset: SensorAsset) -> dict[str, Any]:
    """Return every number of an asset, as plain values with units in their names."""
    return {
        "name": asset.name,
        "made_by": provenance(),
        "spec": asset.spec.model_dump(mode="json"),
        "mass_kg": asset.body.mass_kg,
        "centre_mm": asset.body.centre_mm.tolist(),
        "inertia_kg_m2": asset.body.inertia.tolist(),
        "contact": {
            "spring_n_per_m": asset.spring.tolist(),
            "spring_rms_n": asset.spring_rms,
            "stiffness_n_per_m": asset.stiffness,
            "stiffness_rms_n": asset.stiffness_rms,
            "damping_n_s_per_m": asset.damping,
            "reach_m": asset.reach,
        },
        "camera": {
            **asset.camera.spec.model_dump(mode="json"),
            "lens": asset.camera.lens.name,
            "position_m": asset.camera_position.tolist(),
            "sensor_from_optical": asset.sensor_from_optical.tolist(),
        },
    }
