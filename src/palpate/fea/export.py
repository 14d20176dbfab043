"""Export a press to look at: a VTK file an image, a series in time, and the force as a table.

``press.pvd`` opens the series in ParaView; its time is the depth in mm. The nodes are those of the undeformed mesh
in the dome's frame (*Warp by vector* ``displacement_mm`` shows the deformed dome); cells are quadratic in all three
directions (VTK_TRIQUADRATIC_HEXAHEDRON). Fields at nodes:

* ``displacement_mm``, ``wall_gap_mm`` (distance to the wall's plane; on the outer surface the contact gap);
* ``cauchy_stress_mpa`` (xx, yy, zz, xy, yz, xz), ``von_mises_mpa`` and ``pressure_mpa`` (minus a third of the trace):
  from the Gauss points to the nodes of each cell, then the mean of the cells that share a node. A press solved by
  CalculiX has none: its bricks have another pressure than our cells.
"""

from __future__ import annotations

import csv
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from palpate.core import FloatArray, PalpateError, load_extra, provenance
from palpate.fea.press import Press, azimuth_rotation
from palpate.fea.serendipity import BRICK
from palpate.fea.solid import GAUSS, Solid, State
from palpate.fea.stress import cauchy_stress, von_mises
from palpate.fea.wall import normal_in_mesh, wall_at
from palpate.mesh import gauss_points, shape_hexahedron

_VTK = np.concatenate([BRICK, [12, 14, 10, 16, 4, 22, 13]])
"""Nodes of a cell in VTK's order: brick, then the middles of faces -x, +x, -y, +y, -z, +z, and of the cell."""
_SYMMETRIC = ((0, 3, 5), (3, 1, 4), (5, 4, 2))
"""Places of a tensor's components in xx, yy, zz, xy, yz, zx."""


def check_export(folder: Path) -> None:
    """Refuse an export that could not be written, before anything is solved.

    Raises
    ------
    PalpateError
        If the folder exists, its parent does not, or meshio is missing.
    """
    _meshio()
    if folder.exists():
        raise PalpateError(f"{folder} exists already.", "Name a new folder, or remove that one.")
    if not folder.parent.is_dir():
        raise PalpateError(f"The folder {folder.parent} does not exist.", "Make it first, or name another one.")


def export_press(folder: Path, press: Press) -> None:
    """Export a press to a new folder, which appears whole or not at all.

    Parameters
    ----------
    folder
        Receives ``press_0000.vtu`` …, ``press.pvd`` and ``force.csv``.
    press
        The press.

    Raises
    ------
    PalpateError
        As `check_export`, or if the folder cannot be written.
    """
    check_export(folder)
    part = None
    try:
        part = Path(tempfile.mkdtemp(dir=folder.parent, prefix=f".{folder.name}-"))
        part.chmod(0o755)
        names = _write_images(part, press)
        _write_series(part / "press.pvd", names, press.depth)
        _write_force(part / "force.csv", press)
        os.replace(part, folder)
    except OSError as error:
        raise PalpateError(f"{folder} cannot be written: {error.strerror}.", "Name another folder.") from None
    finally:
        if part is not None:
            shutil.rmtree(part, ignore_errors=True)


def _meshio() -> Any:
    return load_extra("meshio", "viz")


def _write_images(folder: Path, press: Press) -> list[str]:
    meshio = _meshio()
    mesh, turn = press.mesh, _turn(press)
    cells = [("hexahedron27", mesh.cells[:, _VTK])]
    normal = normal_in_mesh(mesh, press.wall)
    solid = None if press.solver.backend == "calculix" else _solid(press)
    names = []
    for k, (depth, u) in enumerate(zip(press.depth, press.displacement, strict=True)):
        plane = wall_at(mesh.dome, normal, float(depth))
        fields = {"displacement_mm": u @ turn.T, "wall_gap_mm": (plane.point - mesh.nodes - u) @ plane.normal}
        if solid is not None:
            fields |= _stress_fields(solid, u, turn)
        names.append(f"press_{k:04d}.vtu")
        image = meshio.Mesh(mesh.nodes @ turn.T, cells, {name: np.ascontiguousarray(f) for name, f in fields.items()})
        meshio.write(folder / names[-1], image)
    return names


def _turn(press: Press) -> FloatArray:
    """Rotation (3, 3) from the frame of the press's displacement to the dome's."""
    return np.eye(3) if press.mesh.spec.whole else azimuth_rotation(press.wall.azimuth_deg)


def _solid(press: Press) -> Solid:
    """The press's body with every node held: nothing is solved, so no pattern of a matrix is made."""
    return Solid(press.mesh.nodes, press.mesh.cells, press.material, np.ones_like(press.mesh.nodes, bool))


def _stress_fields(solid: Solid, u: FloatArray, turn: FloatArray) -> dict[str, FloatArray]:
    """Stress fields at the nodes in the dome's frame."""
    stress = nodal_stress(solid, u)
    tensor = turn @ stress[:, _SYMMETRIC] @ turn.T
    turned = np.stack([tensor[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))], axis=-1)
    return {
        "cauchy_stress_mpa": turned,
        "von_mises_mpa": von_mises(stress),
        "pressure_mpa": -stress[:, :3].mean(axis=1),
    }


def nodal_von_mises(press: Press) -> FloatArray:
    """Von Mises stress (n, n_nodes) in MPa of every image; errors as of `Press.von_mises`."""
    if press.solver.backend == "calculix":
        raise PalpateError("A press solved by CalculiX has no stress at nodes.", "Solve it with palpate.")
    solid = _solid(press)
    return np.stack([von_mises(nodal_stress(solid, u)) for u in press.displacement])


def nodal_stress(solid: Solid, u: FloatArray) -> FloatArray:
    """Cauchy stress (n, 6) MPa at the nodes, order xx, yy, zz, xy, yz, zx, for a displacement (n, 3) mm.

    The pressure of each cell is that of equilibrium, ``p = K M^-1 ∫ q (J - 1) dV`` (`palpate.fea.element`); the 27
    Gauss points define a triquadratic field in each cell, taken at its nodes.
    """
    cells = solid.cells
    F = np.eye(3) + np.einsum("eai,eqaj->eqij", u[cells.nodes], cells.gradient)
    swelling = np.einsum("eq,qk,eq->ek", cells.weight, cells.basis, np.linalg.det(F) - 1.0)
    p = solid.material.bulk_modulus * np.einsum("ekm,em->ek", cells.inverse_mass, swelling)
    at_points = cauchy_stress(solid, State(np.ascontiguousarray(u), p))
    to_nodes = np.linalg.inv(shape_hexahedron(gauss_points(GAUSS)[0])[0])
    at_nodes = np.einsum("aq,eqk->eak", to_nodes, at_points)
    total, count = np.zeros((len(solid.nodes), 6)), np.zeros(len(solid.nodes))
    np.add.at(total, cells.nodes, at_nodes)
    np.add.at(count, cells.nodes, 1.0)
    mean: FloatArray = total / count[:, None]
    return mean


def _write_series(path: Path, names: list[str], depth: FloatArray) -> None:
    root = ElementTree.Element("VTKFile", type="Collection", version="0.1")
    root.append(ElementTree.Comment(f" palpate {provenance()['palpate']}; timestep: depth in mm "))
    collection = ElementTree.SubElement(root, "Collection")
    for name, at in zip(names, depth, strict=True):
        ElementTree.SubElement(collection, "DataSet", timestep=f"{at:.10g}", group="", part="0", file=name)
    ElementTree.indent(root)
    ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)


def _write_force(path: Path, press: Press) -> None:
    """One row an image: force of the whole dome on the wall in the dome's frame, energies, contact."""
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
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*columns, "branch"])
        for row, branch in zip(np.column_stack([*columns.values()]), press.branch, strict=True):
            writer.writerow([*(f"{value:.10g}" for value in row), branch])
