"""CalculiX as a second solver: it agrees with ours, and says clearly what is missing."""

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from errors import refused
from needs import needs_program
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import BallSpec, CalculixSpec, CylinderSpec, ObstacleSpec, Press, WallSpec, solve_press_calculix
from palpate.fea.calculix import stored_energy
from palpate.fea.edge import EdgeSpec
from palpate.fea.read_deck_results import read_blocks, read_increments
from palpate.material import get_material
from palpate.mechanics import EndReason
from palpate.mechanics.serendipity import BRICK, fill_nodes, shape_brick
from palpate.mesh import MeshSpec, measure_quality, mesh_skin
from presses import solve_press

needs_ccx = needs_program("calculix-ccx")
SILICONE = get_material("zaid_2024_ecoflex_00_30")
DOME = build_skin(DomeSpec(height=20, thickness=3))


@dataclass(frozen=True)
class Pair:
    ours: Press
    theirs: Press


@pytest.fixture(scope="module")
def pair() -> Pair:
    mesh = mesh_skin(DOME, MeshSpec(cells=12, core=3, centred=False))
    wall = WallSpec(tilt_deg=10, depth=3.2, contact="frictionless")
    return Pair(solve_press(mesh, SILICONE, wall), solve_press_calculix(mesh, SILICONE, wall))


@pytest.mark.slow
@needs_ccx
class TestAgreement:
    def test_images_are_at_the_same_depths(self, pair: Pair) -> None:
        assert pair.theirs.ended is EndReason.DEPTH_REACHED
        assert pair.theirs.depth == pytest.approx(pair.ours.depth)
        assert list(pair.theirs.branch) == list(pair.ours.branch)
        assert pair.theirs.solved_by == "calculix"

    def test_force_agrees(self, pair: Pair) -> None:
        assert pair.theirs.force[1:, 2] == pytest.approx(pair.ours.force[1:, 2], rel=0.04)
        assert pair.theirs.force[1:, 1] == pytest.approx(-np.tan(np.radians(10)) * pair.theirs.force[1:, 2], rel=1e-4)
        assert pair.theirs.force[:, 0] == pytest.approx(0, abs=1e-12)

    def test_markers_agree(self, pair: Pair) -> None:
        points = place_markers(DOME, MarkerSpec(count=169)).positions
        away = np.linalg.norm(pair.theirs.positions(points) - pair.ours.positions(points), axis=-1)
        assert away[-1].max() < 0.02 * 3.2

    def test_energy_is_the_work_of_the_wall(self, pair: Pair) -> None:
        assert pair.theirs.energy[-1] == pytest.approx(pair.ours.energy[-1], rel=0.04)
        assert pair.theirs.energy[-1] == pytest.approx(pair.theirs.work[-1], rel=0.02)  # of four images

    def test_what_calculix_does_not_give_is_nan(self, pair: Pair) -> None:
        assert np.isnan(pair.theirs.contact_energy).all()
        assert np.isnan(pair.theirs.stabilisation_tension).all()
        assert (pair.theirs.negative_pivots == -1).all()

    def test_the_rest_is_measured(self, pair: Pair) -> None:
        assert pair.theirs.contact_area[-1] == pytest.approx(pair.ours.contact_area[-1], rel=0.15)
        assert pair.theirs.peak_stress[-1] == pytest.approx(pair.ours.peak_stress[-1], rel=0.3)
        assert abs(pair.theirs.apex_gap).max() < 0.02
        assert pair.theirs.cpu_s > 0.1
        assert pair.theirs.newton_iterations > 10
        assert pair.theirs.unknowns < pair.ours.unknowns


@needs_ccx
def test_azimuth_turns_the_force() -> None:
    mesh = mesh_skin(DOME, MeshSpec(cells=6))
    wall = WallSpec(tilt_deg=10, azimuth_deg=90, depth=0.8, contact="frictionless")
    turned = solve_press_calculix(mesh, SILICONE, wall)
    assert turned.force[-1, 0] == pytest.approx(np.tan(np.radians(10)) * turned.force[-1, 2], rel=1e-4)
    assert turned.force[-1, 1] == pytest.approx(0, abs=1e-9)


def test_a_missing_ccx_is_reported_with_the_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    with refused("solver-missing", "apt install calculix-ccx"):
        solve_press_calculix(mesh_skin(DOME, MeshSpec(cells=4)), SILICONE)


def put_ccx(folder: Path, monkeypatch: pytest.MonkeyPatch, script: str) -> None:
    """A program named ccx that does something else; its results go to `folder`."""
    program = folder / "ccx"
    program.write_text(f"#!/bin/sh\n{script}\n")
    program.chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setattr("tempfile.tempdir", str(folder))


def test_a_failed_run_keeps_its_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put_ccx(tmp_path, monkeypatch, "echo ' *ERROR in gauss: no power'; exit 201")
    with refused("solver-no-increment", "201", "in gauss: no power") as raised:
        solve_press_calculix(mesh_skin(DOME, MeshSpec(cells=4)), SILICONE)
    (folder,) = tmp_path.glob("palpate-ccx-*")
    assert str(folder) in raised.value.remedy
    assert {path.name for path in folder.iterdir()} == {"press.inp", "press.log"}


def test_a_run_that_takes_too_long_is_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    put_ccx(tmp_path, monkeypatch, "exec sleep 60")
    with refused("solver-timed-out", "0.2"):
        solve_press_calculix(mesh_skin(DOME, MeshSpec(cells=4)), SILICONE, None, CalculixSpec(timeout=0.2))


DAT = """
 displacements (vx,vy,vz) for set DOME_NODES and time  0.8000000E+00

         1  0.000000E+00 -1.000000E-01  2.000000E+00
         3  1.000000E+00  0.000000E+00  0.000000E+00

 total force (fx,fy,fz) for set WALL_NODES and time  0.8000000E+00

        0.000000E+00  5.000000E-03 -3.000000E-02

 total internal energy for set DOME and time  0.8000000E+00

        2.070407E-02

 stresses (elem, integ.pnt.,sxx,syy,szz,sxy,sxz,syz) for set DOME and time  0.8000000E+00

         1   1  1.000000E-03  1.000000E-03  1.000000E-03  0.000000E+00  0.000000E+00  2.000000E-03
         1   2  5.000000E-03  0.000000E+00  0.000000E+00  0.000000E+00  0.000000E+00  0.000000E+00

 displacements (vx,vy,vz) for set DOME_NODES and time  0.1600000E+01

         1  0.000000E+00 -1.000000E-01  2.000000E+00
"""


def test_results_are_read_and_an_unfinished_increment_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "press.dat"
    path.write_text(DAT)
    assert [block.quantity for block in read_blocks(path)] == [
        "displacements",
        "total force",
        "stresses",
        "displacements",
    ]
    found = read_increments(path, 3)
    assert found.depth == pytest.approx([0.8])
    assert found.displacement[0, 2] == pytest.approx([1, 0, 0])
    assert np.isnan(found.displacement[0, 1]).all()
    assert found.wall_force == pytest.approx(np.array([[0, -0.005, 0.03]]))
    assert found.peak_stress == pytest.approx([5e-3])


def test_no_results_are_no_increments(tmp_path: Path) -> None:
    assert len(read_increments(tmp_path / "none.dat", 3).depth) == 0


def test_shape_functions_are_one_at_their_node_and_sum_to_one() -> None:
    places = np.array([[i - 1.0, j - 1.0, k - 1.0] for k in range(3) for j in range(3) for i in range(3)])
    assert shape_brick(places[BRICK]) == pytest.approx(np.eye(20))
    inside = np.random.default_rng(1).uniform(-1, 1, (50, 3))
    shape = shape_brick(inside)
    assert shape.sum(axis=1) == pytest.approx(1)
    quadratic = (places**2 @ [1, 2, 3] + places[:, 0] * places[:, 1] + places.prod(axis=1))[BRICK]
    expected = inside**2 @ [1, 2, 3] + inside[:, 0] * inside[:, 1] + inside.prod(axis=1)
    assert shape @ quadratic == pytest.approx(expected)


def test_filled_nodes_ignore_what_stood_there() -> None:
    mesh = mesh_skin(DOME, MeshSpec(cells=4))
    linear = mesh.nodes @ np.array([[1.0, 2, 3], [0, 1, 0], [2, 0, 1]])
    broken = linear.copy()
    broken[np.setdiff1d(mesh.cells, mesh.cells[:, BRICK])] = np.nan
    assert np.abs(fill_nodes(mesh.cells, broken) - fill_nodes(mesh.cells, linear)).max() == 0
    assert np.abs(fill_nodes(mesh.cells, broken) - linear).max() < 0.5


def test_stored_energy_of_a_swelling_is_that_of_its_bulk_modulus() -> None:
    mesh = mesh_skin(DOME, MeshSpec(cells=6))
    swollen = 1e-3 * fill_nodes(mesh.cells, mesh.nodes)
    expected = 0.5 * SILICONE.bulk_modulus * (1.001**3 - 1) ** 2 * measure_quality(mesh).volume
    assert stored_energy(mesh, SILICONE, swollen) == pytest.approx(expected, rel=5e-3)


@needs_ccx
@pytest.mark.slow
@pytest.mark.parametrize(
    "obstacle",
    [
        BallSpec(radius=8, offset=4, depth=3, depth_step=1),
        CylinderSpec(radius=8, offset=3, depth=3, depth_step=1),
        EdgeSpec(radius=6, opening_deg=120, offset=2, depth=3, depth_step=1),
    ],
    ids=["ball", "bar", "edge"],
)
def test_a_round_obstacle_presses_in_calculix_as_here(obstacle: ObstacleSpec) -> None:
    obstacle = obstacle.model_copy(update={"contact": "frictionless"})
    mesh = mesh_skin(DOME, MeshSpec(cells=12, core=3, centred=False))
    material = SILICONE.with_bulk_ratio(100.0)
    ours, theirs = solve_press(mesh, material, obstacle), solve_press_calculix(mesh, material, obstacle)
    assert ours.depth == pytest.approx(theirs.depth, abs=1e-3)
    assert theirs.force[1:, 2] == pytest.approx(ours.force[1:, 2], rel=0.03)
    ring = np.array([[8.0, 0.0, 0.0], [0.0, 8.0, 0.0], [-8.0, 0.0, 0.0], [0.0, -8.0, 0.0]])
    points = DOME.nearest(ring + np.array([0.0, 0.0, 18.0]))
    apart = np.linalg.norm(theirs.positions(points)[1:] - ours.positions(points)[1:], axis=-1)
    assert (apart.max(axis=1) < 0.05 * ours.depth[1:]).all()
