"""Exported files, read again: volumes, fields, series and table."""

import csv
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest

from errors import refused
from palpate.design import DomeSpec, build_skin
from palpate.fea import Press, WallSpec, export_press
from palpate.fea.export import nodal_stress
from palpate.fea.nodal_stress import nodal_von_mises
from palpate.material import get_material
from palpate.mechanics.solid import Solid
from palpate.mechanics.stress import von_mises
from palpate.mesh import MeshSpec, gauss_points, measure_quality, mesh_skin
from presses import solve_press

SILICONE = get_material("zaid_2024_ecoflex_00_30")


@pytest.fixture(scope="module")
def press() -> Press:
    mesh = mesh_skin(build_skin(DomeSpec(height=20, thickness=3)), MeshSpec(cells=8))
    return solve_press(mesh, SILICONE, WallSpec(tilt_deg=8, azimuth_deg=30, depth=1.6, contact="frictionless"))


@pytest.fixture(scope="module")
def folder(press: Press, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("export") / "press"
    export_press(folder, press)
    return folder


def vtk_shape(local: np.ndarray) -> np.ndarray:
    """Gradients (n, 27, 3) of VTK's triquadratic hexahedron, from the parametric places of its documentation."""
    corners = [(-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1)]
    edges = [(0, -1, -1), (1, 0, -1), (0, 1, -1), (-1, 0, -1), (0, -1, 1), (1, 0, 1), (0, 1, 1), (-1, 0, 1)]
    upright = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    middles = [(-1, 0, 0), (1, 0, 0), (0, -1, 0), (0, 1, 0), (0, 0, -1), (0, 0, 1), (0, 0, 0)]
    gradient = np.empty((len(local), 27, 3))
    for a, place in enumerate(corners + edges + upright + middles):
        value, slope = zip(*(line(local[:, k], place[k]) for k in range(3)), strict=True)
        for k in range(3):
            gradient[:, a, k] = np.prod([slope[m] if m == k else value[m] for m in range(3)], axis=0)
    return gradient


def line(x: np.ndarray, at: int) -> tuple[np.ndarray, np.ndarray]:
    return (1 - x * x, -2 * x) if at == 0 else ((x * x + at * x) / 2, x + at / 2)


def test_cells_have_the_volume_of_the_mesh(press: Press, folder: Path) -> None:
    image = meshio.read(folder / "press_0000.vtu")
    points, weights = gauss_points((3, 3, 3))
    cells = image.cells_dict["hexahedron27"]
    determinant = np.linalg.det(np.einsum("eai,gaj->egij", image.points[cells], vtk_shape(points)))
    assert determinant.min() > 0
    assert (determinant @ weights).sum() == pytest.approx(measure_quality(press.mesh).volume, rel=1e-9)


def test_displacement_is_that_of_the_press_in_the_domes_frame(press: Press, folder: Path) -> None:
    image = meshio.read(folder / "press_0002.vtu")
    apex = press.mesh.pole_inner
    followed = press.positions(image.points[[apex]])[2, 0] - image.points[apex]
    assert image.point_data["displacement_mm"][apex] == pytest.approx(followed, abs=1e-9)
    assert np.hypot(*image.point_data["displacement_mm"][apex, :2]) > 1e-3
    clamped = np.hypot(*image.points[press.mesh.base, :2].T)
    assert clamped == pytest.approx(np.hypot(*press.mesh.nodes[press.mesh.base, :2].T))


def test_the_outer_surface_stays_below_the_wall(press: Press, folder: Path) -> None:
    for k in range(3):
        gap = meshio.read(folder / f"press_{k:04d}.vtu").point_data["wall_gap_mm"]
        assert gap[press.mesh.outer_faces].min() == pytest.approx(0, abs=0.02)


def test_stress_fields_agree_with_each_other_and_with_the_press(press: Press, folder: Path) -> None:
    data = meshio.read(folder / "press_0002.vtu").point_data
    stress = data["cauchy_stress_mpa"]
    assert stress.shape == (len(press.mesh.nodes), 6)
    assert data["von_mises_mpa"] == pytest.approx(von_mises(stress), abs=1e-12)
    assert data["pressure_mpa"] == pytest.approx(-stress[:, :3].mean(axis=1), abs=1e-12)
    assert data["von_mises_mpa"].max() == pytest.approx(press.peak_stress[2], rel=0.5)


def test_nodal_stress_of_a_uniform_swelling_is_its_pressure(press: Press) -> None:
    solid = Solid(press.mesh.nodes, press.mesh.cells, SILICONE, np.zeros_like(press.mesh.nodes, bool))
    stress = nodal_stress(solid, 1e-3 * press.mesh.nodes)
    expected = SILICONE.bulk_modulus * (1.001**3 - 1)
    assert stress[:, :3] == pytest.approx(expected)
    assert stress[:, 3:] == pytest.approx(0, abs=1e-9)


def test_the_series_lists_every_image_at_its_depth(press: Press, folder: Path) -> None:
    sets = ElementTree.parse(folder / "press.pvd").getroot().findall("./Collection/DataSet")
    assert [float(entry.attrib["timestep"]) for entry in sets] == pytest.approx(press.depth)
    assert {entry.attrib["file"] for entry in sets} == {path.name for path in folder.glob("*.vtu")}


def test_the_table_has_the_force_of_every_image(press: Press, folder: Path) -> None:
    with (folder / "force.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["depth_mm"]) for row in rows] == pytest.approx(press.depth)
    force = np.array([[float(row[name]) for name in ("fx_n", "fy_n", "fz_n")] for row in rows])
    assert force == pytest.approx(press.force, abs=1e-9)


def test_a_press_by_calculix_has_no_stress_field(press: Press, tmp_path: Path) -> None:
    export_press(tmp_path / "press", replace(press, solved_by="calculix"))
    assert set(meshio.read(tmp_path / "press" / "press_0001.vtu").point_data) == {"displacement_mm", "wall_gap_mm"}


def test_what_cannot_be_written_leaves_nothing(
    press: Press, folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with refused("folder-exists"):
        export_press(folder, press)
    with refused("folder-missing"):
        export_press(tmp_path / "no" / "where", press)

    def full(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("palpate.fea.export._write_force", full)
    with refused("disk-unwritable"):
        export_press(tmp_path / "press", press)
    assert list(tmp_path.iterdir()) == []


def test_a_missing_meshio_is_reported_with_the_remedy(
    press: Press, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(__import__("sys").modules, "meshio", None)
    with refused("extra-missing", ".[viz]"):
        export_press(tmp_path / "press", press)


def test_a_press_by_calculix_is_refused_stress_at_its_nodes(press: Press) -> None:
    with refused("press-no-nodal-stress", "calculix"):
        nodal_von_mises(replace(press, solved_by="calculix"))
