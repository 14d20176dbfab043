"""Mesh files for the printer, and drilling of meshes. Only this file uses trimesh."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from palpate.core import FloatArray, PalpateError, load_extra
from palpate.design import SurfaceMesh

_WELD_MM = 1e-4
"""Distance of points that a file of single precision may merge."""
_VOLUME = 0.005
"""Accepted relative difference of the volumes of a written file and its solid."""


def write_mesh(path: Path, mesh: SurfaceMesh, volume: float | None = None) -> None:
    """Write binary STL or 3MF (mm), by the suffix, and compare it with the `volume` (mm³) of its solid.

    Raises
    ------
    PalpateError
        If the mesh is not watertight or faces inward, or the volumes differ by more than 0.5 %.
    """
    volume = mesh.volume if volume is None else volume
    mesh = mesh.welded(_WELD_MM)
    if not mesh.is_watertight or mesh.volume <= 0:
        raise PalpateError(
            f"The mesh for {path.name} is not closed.",
            "Change a dimension by some hundredths of a mm.",
            code="mesh-not-closed",
        )
    body = _trimesh().Trimesh(mesh.points, mesh.triangles, process=False)
    body.units = "mm"
    path.write_bytes(body.export(file_type=path.suffix[1:]))
    written = float(_trimesh().load(path, force="mesh").volume)
    if abs(written / volume - 1) > _VOLUME:
        raise PalpateError(
            f"{path.name} contains {written:.6g} mm³ instead of {volume:.6g} mm³.",
            "Change a dimension by some hundredths of a mm, and report this.",
            code="mesh-file-volume",
        )


def drill(mesh: SurfaceMesh, start: FloatArray, end: FloatArray, diameter: float) -> SurfaceMesh:
    """Drill holes of one diameter (mm) from `start` (n, 3) to `end` (n, 3) mm."""
    trimesh = _trimesh()
    body = trimesh.Trimesh(mesh.points, mesh.triangles, process=False)
    bits = [
        trimesh.creation.cylinder(diameter / 2, segment=[a, b], sections=24) for a, b in zip(start, end, strict=True)
    ]
    drilled = trimesh.boolean.difference([body, trimesh.boolean.union(bits, engine="manifold")], engine="manifold")
    return SurfaceMesh(np.asarray(drilled.vertices, float), np.asarray(drilled.faces, np.int64)).welded(_WELD_MM)


def _trimesh() -> Any:
    load_extra("manifold3d", "cad")  # its engine for booleans, which it would miss only when it drills
    return load_extra("trimesh", "cad")
