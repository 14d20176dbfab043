"""Constants of one dome and one camera, on a dome of half the size and in an image of twice the resolution."""

import numpy as np
import pytest

from palpate.calibration import (
    CONTACT_STATE,
    AccuracySpec,
    PoseFit,
    PoseFitter,
    RobotUncertainty,
    ToleranceSpec,
    build_unit_model,
    infer_from_rest,
    predict_accuracy,
)
from palpate.calibration.fit_pose import TWIN_ERROR_SD, twin_sd
from palpate.calibration.identify import twin_error_sd
from palpate.calibration.noise import MODEL_ERROR_PX
from palpate.calibration.scale import model_px, pixel_scale, scale_contact
from palpate.camera import CameraSpec, build_camera
from palpate.core.state import State
from palpate.design import DomeSpec, MarkerLayout, MarkerSpec, build_skin, place_markers
from palpate.fea import Press, WallSpec, solve_press
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, mesh_skin
from palpate.surrogate import TWIN_DERIVATIVES, Twin, build_twin

ECOFLEX = get_material("zaid_2024_ecoflex_00_30")
SIZES = (1.0, 0.5)
SOLVER = SolverSpec(derivatives=TWIN_DERIVATIVES, edge_share=1.0)
LENGTHS = ("thickness", "print_shift", "marker_position", "camera_offset", "camera_distance", "depth_zero")
POSE = np.array([4.0, -3.0, 2.2])


def skin_of(size: float) -> DomeSpec:
    return DomeSpec(height=20 * size, base_radius=20 * size, thickness=2 * size)


def camera_of(size: float) -> CameraSpec:
    return CameraSpec(distance=48.0 * size)


def tolerance_of(size: float) -> ToleranceSpec:
    usual = ToleranceSpec()
    return ToleranceSpec(**{name: size * getattr(usual, name) for name in LENGTHS})


def layout_of(size: float) -> MarkerLayout:
    usual = place_markers(build_skin(skin_of(1.0)), MarkerSpec(count=91))
    return MarkerLayout(size * usual.positions, size * usual.diameter)


def press(size: float, tilt: float) -> Press:
    wall = WallSpec(tilt_deg=tilt, contact="frictionless", depth=3.0 * size, depth_step=0.6 * size)
    mesh, solver = mesh_skin(build_skin(skin_of(size)), MeshSpec(cells=8)), SOLVER
    return solve_press(mesh, ECOFLEX, wall, solver)


@pytest.fixture(scope="module")
def twins() -> dict[float, Twin]:
    return {size: build_twin([press(size, tilt) for tilt in (0.0, 4.0, 8.0, 12.0)]) for size in SIZES}


def read(twin: Twin, size: float) -> PoseFit:
    layout, camera, tolerance = layout_of(size), camera_of(size), tolerance_of(size)
    rest = build_camera(camera).project(layout.positions)
    belief = infer_from_rest(twin, layout, camera, rest, tolerance, 0.02)
    fitter = PoseFitter(build_unit_model(twin, layout, belief, tolerance), 0.02)
    points = twin.with_markers(layout.positions).evaluate(POSE * [1.0, 1.0, size], 0.0).positions
    return fitter.fit(build_camera(camera).project(points))


def test_the_dome_and_camera_of_the_constants_have_them_exactly() -> None:
    skin = build_skin(DomeSpec(height=20, thickness=2))
    ones = State(CONTACT_STATE, np.ones(len(CONTACT_STATE)))
    assert np.array_equal(scale_contact(ones, skin).values, ones.values)
    assert np.array_equal(twin_sd(skin).values, TWIN_ERROR_SD.values)
    assert model_px(skin, CameraSpec()) == MODEL_ERROR_PX


def test_half_the_size_has_half_the_lengths_and_twice_the_resolution_twice_the_pixels() -> None:
    skin, half = (build_skin(skin_of(size)) for size in SIZES)
    assert twin_sd(half).values == pytest.approx(TWIN_ERROR_SD.values * [1.0, 1.0, 0.5, 1.0])
    scaled = scale_contact(State(CONTACT_STATE, np.ones(len(CONTACT_STATE))), half)
    assert scaled["depth_mm", "curvature", "lateral_x"] == pytest.approx([0.5, 2.0, 0.5])
    assert scaled["rx_deg", "inverse_friction", "twist_deg"].tolist() == [1.0, 1.0, 1.0]
    assert twin_error_sd(half) == pytest.approx(0.5 * twin_error_sd(skin))
    usual = CameraSpec()
    fine = usual.model_copy(update={"fx_px": 2 * usual.fx_px, "fy_px": 2 * usual.fy_px})
    assert model_px(skin, fine) == pytest.approx(2 * MODEL_ERROR_PX)
    assert pixel_scale(half, camera_of(0.5)) == pytest.approx(1.0)


def test_a_sensor_of_half_the_size_in_as_many_pixels_is_as_sure_of_its_angles(twins: dict[float, Twin]) -> None:
    whole, half = (read(twins[size], size) for size in SIZES)
    assert half.half_width[:2] == pytest.approx(whole.half_width[:2], rel=1e-3)
    assert half.half_width[2] == pytest.approx(0.5 * whole.half_width[2], rel=1e-3)


def test_its_units_are_foreseen_to_be_as_good(twins: dict[float, Twin]) -> None:
    figures = []
    for size in SIZES:
        robot = RobotUncertainty(depth=0.02 * size)
        spec = AccuracySpec(min_depth=1.0 * size, max_tilt_deg=9.0, calibration_presses=2, robot=robot, noise_px=0.02)
        camera = build_camera(camera_of(size))
        figures.append(predict_accuracy(twins[size], layout_of(size), camera, tolerance_of(size), spec))
    assert figures[1].rmse_deg == pytest.approx(figures[0].rmse_deg, rel=0.02)
    assert figures[1].depth_rmse == pytest.approx(0.5 * figures[0].depth_rmse, rel=0.02)
