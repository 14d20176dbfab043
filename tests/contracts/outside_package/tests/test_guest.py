"""What the guest adds passes the suites of palpate, and is used like palpate's own."""

from pathlib import Path

import numpy as np
import pytest
from palpate_guest.carroll import Carroll
from palpate_guest.cosine import Bell
from palpate_guest.division import Division
from palpate_guest.neighbours import Neighbours
from palpate_guest.table_robot import TableRobot
from palpate_guest.wheel import WheelSpec

from palpate.camera import CameraSpec, build_camera
from palpate.datasets import read_recording
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers, place_orientation_mark, skin_from_data
from palpate.fea import WallSpec, obstacle_from_data, solve_press
from palpate.material import FitSpec, Loading, Mode, Sample, fit_material, get_material, trace_curve
from palpate.mesh import Mesh, MeshSpec, mesh_skin
from palpate.testing import (
    EstimatorSuite,
    LawSuite,
    LensSuite,
    ObstacleSuite,
    RecordingReaderSuite,
    RobotSuite,
    SkinSuite,
    SourceSuite,
)
from palpate.vision import assign_markers, build_pattern, register_dome

RUBBER = (0.008, 0.00001, 0.006)


class TestCarroll(LawSuite):
    @pytest.fixture
    def law(self) -> Carroll:
        return Carroll(*RUBBER)


class TestDivision(LensSuite):
    @pytest.fixture(params=[-0.3, 0.0, 0.2])
    def lens(self, request: pytest.FixtureRequest) -> Division:
        return Division(request.param)


class TestNeighbours(EstimatorSuite):
    @pytest.fixture
    def kind(self) -> type[Neighbours]:
        return Neighbours


class TestStack(SourceSuite):
    @pytest.fixture
    def text(self, tmp_path: Path) -> str:
        np.save(tmp_path / "three.npy", np.arange(3 * 48 * 64, dtype=np.uint16).reshape(3, 48, 64))
        return str(tmp_path / "three.npy")

    @pytest.fixture
    def missing(self, tmp_path: Path) -> str:
        return str(tmp_path / "none.npy")


def test_a_dome_of_the_guests_law_is_pressed() -> None:
    material = get_material("carroll:0.008,0.00001,0.006")
    mesh = mesh_skin(build_skin(DomeSpec()), MeshSpec(cells=6))
    press = solve_press(mesh, material, WallSpec(tilt_deg=5.0, depth=2.0))
    assert press.depth[-1] == pytest.approx(2.0)
    plain = solve_press(
        mesh, get_material(f"neo-hooke:{material.law.shear_modulus / 2}"), WallSpec(tilt_deg=5.0, depth=2.0)
    )
    assert np.linalg.norm(press.force[-1]) == pytest.approx(np.linalg.norm(plain.force[-1]), rel=0.2)


def test_the_guests_law_is_fitted_to_a_curve() -> None:
    stretch = np.linspace(1.0, 3.0, 60)[1:]
    curve = trace_curve(get_material("carroll:0.008,0.00001,0.006"), Mode.UNIAXIAL, stretch)
    fit = fit_material([Sample("made", Loading.TENSION, stretch, curve.nominal)], FitSpec(model="carroll"))
    assert fit.linear == pytest.approx(RUBBER, rel=1e-6)


def test_a_camera_under_a_dome_is_registered_and_the_guests_lens_refined() -> None:
    dome = build_skin(DomeSpec())
    layout = place_markers(dome, MarkerSpec(count=169))
    mark = place_orientation_mark(dome, layout)
    nominal = CameraSpec(lens="division", distortion=(-0.2,))
    there = build_camera(nominal.model_copy(update={"distortion": (-0.25,), "offset_x": 0.4, "roll_deg": 3.0}))
    naming = assign_markers(
        there.project(np.vstack([layout.positions, mark])),
        build_pattern(layout.positions, build_camera(nominal).project, mark),
    )
    held, refined = (register_dome(naming, layout, dome, nominal, refine) for refine in (False, True))
    assert held.camera.spec.distortion == (-0.2,)
    assert refined.rms_px < 0.3 * held.rms_px
    assert refined.camera.spec.distortion[0] == pytest.approx(-0.25, abs=0.02)
    assert refined.camera.spec.offset_x == pytest.approx(0.4, abs=0.05)


class TestBell(SkinSuite):
    @pytest.fixture
    def skin(self) -> Bell:
        return Bell(12.0, 20.0, 2.0)


class TestWheel(ObstacleSuite):
    @pytest.fixture
    def spec(self) -> WheelSpec:
        return WheelSpec()

    @pytest.fixture
    def mesh(self) -> Mesh:
        return mesh_skin(build_skin(DomeSpec()), MeshSpec(cells=6))


def test_the_guests_obstacle_is_pressed_into_the_guests_skin() -> None:
    mesh = mesh_skin(skin_from_data({"kind": "bell", "height": 14}).build(), MeshSpec(cells=8))
    spec = obstacle_from_data(
        {"kind": "wheel", "radius": 6, "depth": 1.6, "depth_step": 0.2, "contact": "frictionless"}
    )
    press = solve_press(mesh, get_material("neo-hooke:0.0141"), spec)
    assert press.depth[-1] == pytest.approx(1.6)
    assert press.work[-1] == pytest.approx(press.energy[-1] + press.contact_energy[-1], rel=5e-3)


class TestNpzReader(RecordingReaderSuite):
    @pytest.fixture
    def place(self, tmp_path: Path) -> Path:
        rng = np.random.default_rng(0)
        poses = {name: rng.uniform(-5, 5, 24) for name in ("rx_deg", "ry_deg")}
        images = rng.integers(0, 255, (24, 48, 64), np.uint8)
        with (tmp_path / "all.presses").open("wb") as file:
            np.savez(file, images=images, press=np.arange(24) // 3, **poses)
        return tmp_path / "all.presses"

    @pytest.fixture
    def damaged(self, tmp_path: Path) -> Path:
        (tmp_path / "torn.presses").write_bytes(b"PK torn")
        return tmp_path / "torn.presses"

    def test_a_folder_that_holds_one_is_read_as_well(self, place: Path) -> None:
        assert len(read_recording(place.parent)) == 24


class TestTableRobot(RobotSuite):
    @pytest.fixture
    def robot(self) -> TableRobot:
        return TableRobot()
