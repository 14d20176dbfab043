"""Export of a press: a VTK file for each increment, a time series, and force and contact as tables.

``press.pvd`` opens the series in ParaView; its time is the depth in mm. The nodes are those of the undeformed mesh
in the skin's frame (*Warp by vector* ``displacement_mm`` shows the deformed skin); cells are quadratic in all three
directions (VTK_TRIQUADRATIC_HEXAHEDRON). Fields at nodes:

* ``displacement_mm``, ``wall_gap_mm`` (distance to the obstacle; on the outer surface the contact gap);
* ``cauchy_stress_mpa`` (xx, yy, zz, xy, yz, xz), ``von_mises_mpa`` and ``pressure_mpa`` (minus a third of the trace):
  extrapolated from the Gauss points to the nodes of each cell, then averaged over the cells that share a node;
* ``contact_pressure_mpa`` and ``shear_traction_mpa``: force of the skin on the obstacle per deformed area.

Stress and traction are missing for a press solved by CalculiX, whose bricks define the pressure differently.
``contact.csv`` has the traction at the nodes of the whole skin, also of a half model.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from palpate.core import FloatArray, PalpateError, atomic_folder, load_extra, provenance
from palpate.core.report import write_csv
from palpate.fea.contact_traction import ContactTraction, contact_traction
from palpate.fea.nodal_stress import clamped_solid, nodal_stress
from palpate.fea.press import Press
from palpate.mechanics import BRICK, Solid, von_mises

_VTK = np.concatenate([BRICK, [12, 14, 10, 16, 4, 22, 13]])
"""Nodes of a cell in VTK's order: brick, centres of faces -x, +x, -y, +y, -z, +z, centre of the cell."""
_SYMMETRIC = ((0, 3, 5), (3, 1, 4), (5, 4, 2))
"""Indices of a tensor's components in xx, yy, zz, xy, yz, zx."""


def check_export(folder: Path) -> None:
    """Check that an export can be written, before anything is solved.

    Raises
    ------
    PalpateError
        If the folder exists, its parent does not, or meshio is missing.
    """
    _meshio()
    if folder.exists():
        raise PalpateError(
            f"{folder} already exists.", "Name a new folder, or remove this one.", code="folder-exists"
        )
    if not folder.parent.is_dir():
        raise PalpateError(
            f"The folder {folder.parent} does not exist.",
            "Create it first, or name another folder.",
            code="folder-missing",
        )


def export_press(folder: Path, press: Press) -> None:
    """Export a press to a new folder: ``press_0000.vtu`` …, ``press.pvd``, ``force.csv``, ``contact.csv``.

    Raises
    ------
    PalpateError
        As `check_export`, or if the folder cannot be written.
    """
    check_export(folder)
    with atomic_folder(folder, "Name another folder.") as part:
        contact = contact_traction(press) if press.solved_by == "palpate" else None
        names = _write_images(part, press, contact)
        _write_series(part / "press.pvd", names, press.depth)
        _write_force(part / "force.csv", press)
        if contact is not None:
            _write_contact(part / "contact.csv", press, contact)


def _meshio() -> Any:
    return load_extra("meshio", "viz")


def _write_images(folder: Path, press: Press, contact: ContactTraction | None) -> list[str]:
    meshio = _meshio()
    mesh, turn = press.mesh, press.obstacle.turn(press.mesh)
    cells = [("hexahedron27", mesh.cells[:, _VTK])]
    path = press.obstacle.path(mesh)
    solid = clamped_solid(press)
    names = []
    for k, (depth, u) in enumerate(zip(press.depth, press.displacement, strict=True)):
        gap = -path(float(depth)).penetration(mesh.nodes + u)
        fields = {"displacement_mm": u @ turn.T, "wall_gap_mm": gap}
        if contact is not None:
            fields |= _stress_fields(solid, u, turn)
            fields["contact_pressure_mpa"] = contact.pressure[k]
            fields["shear_traction_mpa"] = contact.shear[k] @ turn.T
        names.append(f"press_{k:04d}.vtu")
        increment = meshio.Mesh(
            mesh.nodes @ turn.T, cells, {name: np.ascontiguousarray(f) for name, f in fields.items()}
        )
        meshio.write(folder / names[-1], increment)
    return names


def _stress_fields(solid: Solid, u: FloatArray, turn: FloatArray) -> dict[str, FloatArray]:
    """Return the stress fields at the nodes in the skin's frame."""
    stress = nodal_stress(solid, u)
    tensor = turn @ stress[:, _SYMMETRIC] @ turn.T
    turned = np.stack([tensor[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))], axis=-1)
    return {
        "cauchy_stress_mpa": turned,
        "von_mises_mpa": von_mises(stress),
        "pressure_mpa": -stress[:, :3].mean(axis=1),
    }


def _write_series(path: Path, names: list[str], depth: FloatArray) -> None:
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    root.append(ElementTree.Comment(f" palpate {provenance()['palpate']}; timestep: depth in mm "))
    collection = ElementTree.SubElement(root, "Collection")
    for name, at in zip(names, depth, strict=True):
        ElementTree.SubElement(collection, "DataSet", timestep=f"{at:.10g}", group="", part="0", file=name)
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)


def _write_force(path: Path, press: Press) -> None:
    """Write one row for each increment: force of the whole skin in its frame, energies, contact."""
    columns = {
        "depth_mm": press.depth,
        "fx_n": press.force[:, 0],
        "fy_n": press.force[:, 1],
        "fz_n": press.force[:, 2],
        "energy_mj": press.energy,
        "work_mj": press.work,
        "contact_area_mm2": press.contact_area,
        "apex_gap_mm": press.apex_gap,
        "peak_von_mises_mpa": press.peak_stress,
    }
    numbers = np.column_stack([*columns.values()])
    rows = ([*(f"{value:.10g}" for value in row), one] for row, one in zip(numbers, press.branch, strict=True))
    write_csv(path, rows, [*columns, "branch"])


def _write_contact(path: Path, press: Press, contact: ContactTraction) -> None:
    """Write one row for each increment and node of the outer surface of the whole skin."""
    mesh, turn = press.mesh, press.obstacle.turn(press.mesh)
    there = np.flatnonzero(contact.area.any(axis=0))
    halved = np.isin(there, mesh.mirror)
    rows: list[list[float]] = []
    for depth, u, part in zip(press.depth, press.displacement, zip(*contact, strict=True), strict=True):
        pressure, shear, normal, area = (each[there] for each in part)
        place, traction = (mesh.nodes + u)[there], pressure[:, None] * normal + shear
        if not mesh.spec.whole:
            area = np.concatenate([np.where(halved, 2.0 * area, area), area[~halved]])
            pressure = np.concatenate([pressure, pressure[~halved]])
            place, traction = (np.vstack([each, each[~halved] * [-1.0, 1.0, 1.0]]) for each in (place, traction))
        at = np.full(len(area), depth)
        rows += np.column_stack([at, place @ turn.T, pressure, traction @ turn.T, area]).tolist()
    head = ["depth_mm", "x_mm", "y_mm", "z_mm", "pressure_mpa", "tx_mpa", "ty_mpa", "tz_mpa", "area_mm2"]
    write_csv(path, ([f"{value:.6g}" for value in row] for row in rows), head)
