"""An edge pressed into a dome, from presses to readings: offset, angle and depth, also where it crosses the axis."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from errors import refused
from needs import needs
from palpate.camera import build_camera
from palpate.datasets import DatasetSpec, generate_dataset, read_dataset, write_dataset
from palpate.design import Design, DomeSpec, MarkerSpec, PoseSpace, build_skin, place_markers
from palpate.fea.edge import EdgeSpec
from palpate.learn import (
    TrainingSpec,
    calibrate_interval,
    compute_error_bounds,
    open_predictor,
    train,
    write_estimator,
)
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin
from palpate.sensor import Unit, open_sensor, run_sensor, write_readings
from palpate.simulation import SimulatedSource
from palpate.surrogate import build_field
from presses import solve_press

LINES = PoseSpace.for_lines()
DOME = build_skin(DomeSpec())
LAYOUT = place_markers(DOME, MarkerSpec(count=37))
SILICONE = get_material("zaid_2024_ecoflex_00_30")
MESH = mesh_skin(DOME, MeshSpec(cells=6, core=4))


def press(offset, azimuth_deg=0.0, mesh=MESH):
    edge = EdgeSpec(radius=3, opening_deg=120, offset=offset, azimuth_deg=azimuth_deg, depth=4.0, depth_step=0.5)
    return solve_press(mesh, SILICONE, edge.model_copy(update={"contact": "frictionless"}))


@pytest.fixture(scope="module")
def presses():
    return [press(offset) for offset in (0.0, 2.0, 4.0)]


@pytest.fixture(scope="module")
def dataset(presses):
    return generate_dataset(presses, LAYOUT, build_camera(), DatasetSpec(n_presses=500, jitter_px=0.2))


@pytest.fixture(scope="module")
def estimator(dataset):
    needs("torch")
    return train(dataset, TrainingSpec(width=32, epochs=150, repeats=1))


def test_lines_are_spread_evenly_by_offset_and_angle(dataset, tmp_path):
    assert dataset.space == LINES
    first = np.unique(dataset.press, return_index=True)[1]
    offset, angle = LINES.line(dataset.poses[first]).T
    for values, low, high in ((np.abs(offset), 0.0, 4.0), (angle, -90.0, 90.0)):
        counts, _ = np.histogram(values, 8, (low, high))
        assert counts.sum() == 500
        assert counts.min() > 50
    write_dataset(tmp_path / "edge.h5", dataset)
    assert read_dataset(tmp_path / "edge.h5").space == LINES


@pytest.mark.parametrize(("offset", "azimuth_deg"), [(2.0, 30.0), (-2.0, 30.0), (1.5, -70.0)])
def test_images_are_those_of_an_edge_pressed_at_its_pose(presses, offset, azimuth_deg):
    """Pressed there by itself in a whole dome; the field was made of edges along x, between two of which one lies."""
    whole = press(offset, azimuth_deg, mesh_skin(DOME, MeshSpec(cells=6, core=4, whole=True)))
    x, y, *_ = LINES.pose(offset, azimuth_deg, 4.0)
    found = build_field(presses, LAYOUT).positions(np.array([x]), np.array([y]), 7)[0]
    there = whole.positions(LAYOUT.positions)[-1]
    moved = np.linalg.norm(there - LAYOUT.positions, axis=1).max()
    assert np.abs(found - there).max() < 0.04 * moved
    turned = build_field(presses, LAYOUT).positions(np.array([y]), np.array([-x]), 7)[0]
    assert np.abs(turned - there).max() > 0.2 * moved


def test_offset_and_angle_are_learnt_where_the_place_alone_does_not_tell_them(dataset, estimator):
    held = dataset.subset(validation=True)
    deep = held.poses[:, 2] > 2
    found, true = estimator.predict(held.images_px[deep]), held.poses[deep]
    offset, angle = LINES.line_error(found, true).T
    assert np.sqrt(np.mean(offset**2)) < 0.15
    assert np.sqrt(np.mean(angle**2)) < 2.5
    near = np.abs(LINES.line(true)[:, 0]) < 0.5
    assert near.sum() > 20
    assert np.sqrt(np.mean(angle[near] ** 2)) < 2.5
    across = np.degrees(np.arctan2(found[near, 1], found[near, 0])) - 90.0
    by_place = (across - LINES.line(true)[near, 1] + 90.0) % 180.0 - 90.0
    assert np.sqrt(np.mean(by_place**2)) > 8.0


def test_a_simulated_sensor_reads_offset_and_angle_of_an_edge(dataset, estimator, presses, tmp_path):
    path = tmp_path / "edge.onnx"
    write_estimator(path, calibrate_interval(estimator, dataset))
    predictor = open_predictor(path)
    assert predictor.space == LINES
    unit = Unit(Design.of_skin(DOME, LAYOUT))
    for touched, offset, azimuth_deg in ((presses[1], 2.0, 150.0), (presses[0], 0.0, 70.0)):
        wall = touched.obstacle.model_copy(update={"azimuth_deg": azimuth_deg})
        source = SimulatedSource(unit, [replace(touched, obstacle=wall)])
        images = source.images()
        sensor = open_sensor([next(images)], unit, predictor)
        readings = list(
            write_readings(
                tmp_path / f"{azimuth_deg:g}.csv", run_sensor(sensor, islice(images, 9 + 20)), predictor.space
            )
        )
        error = LINES.line_error(readings[-1].pose, LINES.pose(offset, azimuth_deg, readings[-1].depth_mm))
        assert abs(error[0]) < 0.4
        assert abs(error[1]) < 4.0
        assert readings[-1]["depth_mm"] == readings[-1].depth_mm
        assert readings[-1].line == pytest.approx(tuple(LINES.line(readings[-1].pose)))
        columns = (tmp_path / f"{azimuth_deg:g}.csv").read_text().split(",")
        assert columns[1:6] == ["x_mm", "y_mm", "depth_mm", "cos2_deg", "sin2_deg"]


def test_no_limit_is_told_of_an_edge(dataset, presses):
    with refused("limit-obstacle-level"):
        compute_error_bounds(build_field(presses, LAYOUT), build_camera(), dataset.spec)
