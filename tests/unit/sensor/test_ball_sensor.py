"""A ball pressed into a dome, from presses to readings: the pose is its place and its depth."""

import csv
from itertools import islice

import numpy as np
import pytest

from errors import refused
from needs import needs
from palpate.camera import build_camera
from palpate.datasets import DatasetSpec, generate_dataset, read_dataset, write_dataset
from palpate.design import (
    OFFSET_SPACE,
    TILT_SPACE,
    Design,
    DomeSpec,
    MarkerSpec,
    build_skin,
    place_markers,
)
from palpate.fea import BallSpec, WallSpec
from palpate.learn import (
    TrainingSpec,
    calibrate_interval,
    compute_error_bounds,
    evaluate,
    open_predictor,
    train,
    write_estimator,
)
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin
from palpate.sensor import Unit, check_model, open_sensor, run_sensor, write_readings
from palpate.simulation import SimulatedSource, sample_presses
from palpate.surrogate import build_field
from presses import solve_press

DOME = build_skin(DomeSpec())
LAYOUT = place_markers(DOME, MarkerSpec(count=37))
SILICONE = get_material("zaid_2024_ecoflex_00_30")
MESH = mesh_skin(DOME, MeshSpec(cells=6, core=4))


def press(offset, azimuth_deg=0.0, mesh=MESH):
    ball = BallSpec(
        radius=10, offset=offset, azimuth_deg=azimuth_deg, depth=4.0, depth_step=0.5, contact="frictionless"
    )
    return solve_press(mesh, SILICONE, ball)


@pytest.fixture(scope="module")
def presses():
    return [press(offset) for offset in (0.0, 2.0, 4.0)]


@pytest.fixture(scope="module")
def dataset(presses):
    return generate_dataset(presses, LAYOUT, build_camera(), DatasetSpec(n_presses=300, jitter_px=0.2))


@pytest.fixture(scope="module")
def predictor(dataset, tmp_path_factory):
    needs("torch")
    estimator = train(dataset, TrainingSpec(width=32, epochs=150, repeats=1))
    errors = evaluate(estimator, dataset)
    assert list(errors.by_axis) == ["offset", "x", "y", "depth"]
    assert errors.by_tilt == ()
    assert errors.pooled.rmse < 0.2
    path = tmp_path_factory.mktemp("ball") / "ball.onnx"
    write_estimator(path, calibrate_interval(estimator, dataset))
    return open_predictor(path)


def test_places_of_a_ball_fill_the_disc_that_was_pressed(dataset, tmp_path):
    assert dataset.space == OFFSET_SPACE
    assert 3.8 < np.hypot(*dataset.poses[:, :2].T).max() <= 4.0
    write_dataset(tmp_path / "ball.h5", dataset)
    assert read_dataset(tmp_path / "ball.h5").space == OFFSET_SPACE


@pytest.mark.parametrize(("azimuth_deg", "share"), [(90.0, 0.002), (150.0, 0.02)])
def test_markers_of_a_ball_beside_the_axis_follow_it_to_every_azimuth(presses, azimuth_deg, share):
    """Pressed there by itself, in a whole dome: the field was made from half domes at azimuth 0.

    At 90° both have the same cells beneath the ball; at 150° they differ, and with them the markers.
    """
    mesh = mesh_skin(DOME, MeshSpec(cells=6, core=4, whole=True))
    whole = press(2.0, azimuth_deg, mesh).positions(LAYOUT.positions)[-1]
    x, y = 2.0 * np.cos(np.radians(azimuth_deg)), 2.0 * np.sin(np.radians(azimuth_deg))
    found = build_field(presses, LAYOUT).positions(np.array([x]), np.array([y]), 7)[0]
    moved = np.linalg.norm(whole - LAYOUT.positions, axis=1).max()
    assert np.abs(found - whole).max() < share * moved


def test_limits_of_a_ball_are_of_its_place(dataset, presses):
    limits = compute_error_bounds(build_field(presses, LAYOUT), build_camera(), dataset.spec)
    assert all(0.0 < limit.least_squares_deg < 0.5 for limit in limits)


def test_a_simulated_sensor_reads_where_a_ball_presses(predictor, presses, tmp_path):
    assert predictor.space == OFFSET_SPACE
    unit = Unit(Design.of_skin(DOME, LAYOUT))
    source = SimulatedSource(unit, sample_presses(presses[1:2], seed=3))
    images = source.images()
    sensor = open_sensor([next(images)], unit, predictor)
    seen, truths = [], []
    for image in islice(images, 9 + 20):
        seen.append(image)
        truths.append(source.truth)
    path = tmp_path / "readings.csv"
    readings = list(write_readings(path, run_sensor(sensor, seen), predictor.space))
    for reading, truth in list(zip(readings, truths, strict=True))[-5:]:
        assert reading.pose == pytest.approx(truth, abs=0.4)
        assert reading.radial == pytest.approx(2.0, abs=0.4)
        assert reading["depth_mm"] == reading.depth_mm
    with path.open(newline="") as file:
        assert next(csv.reader(file))[:7] == [
            "image", "x_mm", "y_mm", "depth_mm", "x_half_width_mm", "y_half_width_mm", "depth_half_width_mm"
        ]  # fmt: skip


def test_a_model_of_a_ball_is_refused_where_tilts_are_asked_for(predictor):
    with refused("model-outputs-differ", "x_mm, y_mm, depth_mm", "rx_deg, ry_deg, depth_mm"):
        check_model(predictor, Unit(Design.of_skin(DOME, LAYOUT)), TILT_SPACE)


def test_presses_of_a_ball_and_of_a_wall_are_not_mixed(presses):
    wall = solve_press(MESH, SILICONE, WallSpec(depth=1.0, depth_step=0.5, contact="frictionless"))
    with refused("presses-obstacles-differ"):
        generate_dataset([wall, *presses], LAYOUT, build_camera(), DatasetSpec(n_presses=20))


def test_protocols_of_tilts_are_refused_for_a_ball(presses):
    with refused("protocol-not-for-obstacle", "paper-91"):
        generate_dataset(presses, LAYOUT, build_camera(), DatasetSpec(poses="paper-91"))
