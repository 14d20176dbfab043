"""The chain from rendered images of a made-up press to readings, by a model fitted in closed form."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from errors import refused
from palpate.camera import CameraSpec, RenderSpec, build_camera, flat_marker_outlines, render
from palpate.core import PalpateError, generator
from palpate.datasets import Normalisation
from palpate.design import (
    TILT_SPACE,
    Design,
    DomeSpec,
    MarkerSpec,
    build_skin,
    place_markers,
    place_orientation_mark,
)
from palpate.learn import Estimator, Prediction, open_predictor, write_estimator
from palpate.sensor import (
    Flag,
    SensorSpec,
    Unit,
    describe_reading,
    open_sensor,
    run_sensor,
    write_readings,
)
from palpate.sensor.sensor import analyse_rest
from palpate.vision import DetectSpec, assign_markers, build_pattern, register_dome

DOME = build_skin(DomeSpec())
LAYOUT = place_markers(DOME, MarkerSpec(count=91))
MARK = place_orientation_mark(DOME, LAYOUT)
MOVED = CameraSpec(offset_x=0.4, offset_y=-0.3, distance=48.6, tilt_x_deg=1.2, tilt_y_deg=-0.8, roll_deg=25.0)
SPOILED = {"vignetting": 0.3, "blur_px": 0.7, "noise": 2.0, "dirt": 5, "rim": True}


def pressed(points, pose):
    """A smooth made-up press: the apex follows the wall, the rest less, aside and unevenly with the angles."""
    rx, ry, depth = pose
    near = np.exp(-(DOME.height - points[:, 2]) / 6.0)[:, None]
    slope = (points[:, :1] * ry - points[:, 1:2] * rx) * 0.03
    still = np.zeros_like(slope)
    return points + near * np.concatenate(
        [0.03 * depth * ry + still, -0.03 * depth * rx + still, -depth - slope * min(depth, 1.0)], axis=1
    )


def photograph(pose, camera_spec=None, seed=0, **spoiled):
    points = pressed(np.vstack([LAYOUT.positions, MARK]), pose)
    normals = (np.vstack([LAYOUT.positions, MARK]) - [0, 0, DOME.center_z]) / DOME.radius
    return render(
        build_camera(camera_spec),
        flat_marker_outlines(points, normals, LAYOUT.diameter),
        RenderSpec(seed=seed, **spoiled),
    )


def toothed_rim(image, middle_px, radius, width, level, teeth, seed):
    """A bright ring about the dots that teeth of light cut into; beside the teeth it looks dotted."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[: image.shape[0], : image.shape[1]] - np.array(middle_px)[::-1, None, None]
    away, turn = np.hypot(x, y), np.arctan2(y, x)
    ring = 1 / (1 + np.exp((radius - away) / 1.2)) / (1 + np.exp((away - radius - width) / 1.2))
    light = level * (0.6 + 0.4 * np.sin(teeth * turn + seed)) * (1 + 0.15 * rng.standard_normal(image.shape))
    return np.clip(image + ring * light, 0, 255).astype(np.uint8)


@pytest.fixture(scope="module")
def predictor(tmp_path_factory):
    rng, camera = generator(0, "poses"), build_camera()
    poses = np.column_stack([rng.uniform(-8, 8, (4000, 2)), rng.uniform(3, 8, 4000)])
    images = np.stack([camera.project(pressed(LAYOUT.positions, pose)) for pose in poses])
    rest = camera.project(LAYOUT.positions)
    scale = Normalisation((173.0, 130.0), (173.0, 130.0))
    inputs, mean, sd = scale.apply(images).reshape(len(poses), -1), poses.mean(axis=0), poses.std(axis=0)
    # random features and least squares: a network without training
    centre, spread = inputs.mean(axis=0), np.linalg.svd(inputs - inputs.mean(axis=0), full_matrices=False)
    first = spread[2][:5].T / spread[1][:5] * np.sqrt(len(poses)) @ rng.normal(0, 0.6, (5, 150))
    shift = rng.uniform(-2, 2, 150) - centre @ first
    hidden = inputs @ first + shift
    hidden = hidden / (1 + np.exp(-hidden))
    design = np.column_stack([hidden, np.ones(len(poses))])
    normal = design.T @ design + 1e-3 * np.eye(151)
    last = np.linalg.solve(normal, design.T @ ((poses - mean) / sd))
    estimator = Estimator(
        normalisation=scale,
        weights=(first[None], last[None, :-1]),
        biases=(shift[None], last[None, -1]),
        activation="silu",
        output_mean=mean,
        output_sd=sd,
        rest_px=rest,
        seed=0,
        made_by={"method": "test"},
        training_images=len(poses),
        validation_images=0,
    )
    path = tmp_path_factory.mktemp("model") / "m.onnx"
    write_estimator(path, estimator)
    return open_predictor(path)


def opened(predictor, camera=None, **spoiled):
    return open_sensor([photograph((0, 0, 0), camera, **spoiled)], Unit(Design.of_skin(DOME, LAYOUT)), predictor)


@pytest.mark.parametrize("camera", [None, MOVED])
@pytest.mark.parametrize("spoiled", [{}, SPOILED])
def test_a_press_is_read_from_images_whatever_the_camera_and_the_light(predictor, camera, spoiled):
    sensor = opened(predictor, camera, **spoiled)
    truth = [(5.0, -3.0, depth) for depth in np.arange(0.8, 8.0, 0.8)]
    images = [photograph(pose, camera, seed=k, **spoiled) for k, pose in enumerate(truth)]
    readings = list(run_sensor(sensor, images))
    assert all(reading.touching and not reading.flags for reading in readings)
    for pose, reading in list(zip(truth, readings, strict=True))[3:]:
        assert abs(reading["rx_deg"] - pose[0]) < 1.0
        assert abs(reading["ry_deg"] - pose[1]) < 1.0
        assert abs(reading.depth_mm - pose[2]) < 0.3
        assert reading.radial == pytest.approx(np.hypot(*reading.pose[:2]))


def test_a_press_is_read_through_a_fisheye_by_a_model_of_the_nominal_camera(predictor):
    fisheye = MOVED.model_copy(update={"lens": "kannala-brandt", "distortion": (-0.05, 0.01, -0.05, 0.02)})
    unit = Unit(Design.of_skin(DOME, LAYOUT), lens=CameraSpec(lens=fisheye.lens, distortion=fisheye.distortion))
    sensor = open_sensor([photograph((0, 0, 0), fisheye)], unit, predictor)
    assert sensor.registration.rms_px < 0.2
    assert sensor.registration.camera.spec.offset_x == pytest.approx(MOVED.offset_x, abs=0.1)
    for pose in ((4.0, -3.0, 4.0), (-3.0, 5.0, 6.0)):
        reading = sensor.read(photograph(pose, fisheye))
        assert reading.pose[:2] == pytest.approx(pose[:2], abs=1.0)
        assert reading.depth_mm == pytest.approx(pose[2], abs=0.3)


def test_an_untouched_dome_is_not_touched(predictor):
    sensor = opened(predictor, **SPOILED)
    assert not any(sensor.read(photograph((0, 0, 0), seed=k, **SPOILED)).touching for k in range(1, 6))


def test_the_cameras_pose_is_found(predictor):
    sensor = opened(predictor, MOVED, blur_px=0.7, noise=2.0)
    found = sensor.registration
    for name, near in {
        "offset_x": 0.05,
        "offset_y": 0.05,
        "distance": 0.1,
        "tilt_x_deg": 0.05,
        "roll_deg": 0.02,
    }.items():
        assert getattr(found.camera.spec, name) == pytest.approx(getattr(MOVED, name), abs=near), name
    assert found.rms_px < 0.1
    assert np.isfinite(found.reprojection_residual_px).all()
    assert (found.sd < 0.05).all()


def test_register_dome_shows_a_misprinted_dot():
    camera = build_camera(MOVED)
    pixels = camera.project(np.vstack([LAYOUT.positions, MARK]))
    pixels[40] += [1.5, -1.0]
    naming = assign_markers(pixels, build_pattern(LAYOUT.positions, build_camera().project, MARK))
    errors = np.linalg.norm(register_dome(naming, LAYOUT, DOME).reprojection_residual_px, axis=1)
    assert errors.argmax() == 40
    assert errors[40] == pytest.approx(1.8, abs=0.2)
    assert np.median(errors) < 0.1


@pytest.mark.parametrize(("share", "right"), [(0.02, True), (0.15, False)])
def test_dots_off_by_more_than_a_twentieth_of_their_spacing_are_another_design(share, right):
    """Markers without rings, of which no law explains a misfit at random."""
    rng = generator(5, "off")
    layout = replace(LAYOUT, positions=LAYOUT.positions + np.pad(rng.uniform(-0.3, 0.3, (91, 2)), ((0, 0), (0, 1))))
    naming = assign_markers(
        build_camera().project(np.vstack([LAYOUT.positions, MARK])),
        build_pattern(LAYOUT.positions, build_camera().project, MARK),
    )
    seen = build_camera().project(layout.positions)
    spacing = np.median(np.sort(np.linalg.norm(seen[:, None] - seen, axis=2), axis=1)[:, 1])
    moved = replace(naming, positions_px=seen + share * spacing / np.sqrt(2.0) * rng.normal(size=seen.shape))
    if right:
        found = register_dome(moved, layout, DOME)
        assert found.rms_px == pytest.approx(share * spacing, rel=0.2)
        assert found.distortion is None
        return
    with refused("layout-misfit"):
        register_dome(moved, layout, DOME)


@pytest.mark.parametrize(("printed", "known"), [(0.0, 0.002), (0.1, 0.01)])
def test_the_lens_is_refined_as_far_as_an_image_at_rest_knows_it(printed, known):
    """A lens 2 % and 4 px off comes back: with dots off by 0.1 mm less well, and its deviation says so."""
    layout = place_markers(DOME, MarkerSpec(count=169))
    rng, nominal = generator(3, "lens", printed), CameraSpec()
    lens = {"fx_px": 1.02 * nominal.fx_px, "fy_px": 1.02 * nominal.fy_px, "cx_px": 179.0, "cy_px": 125.0}
    points = np.vstack([layout.positions, place_orientation_mark(DOME, layout)])
    projected = build_camera(MOVED.model_copy(update=lens)).project
    pixels = projected(points + printed * np.pad(rng.uniform(-1, 1, (170, 2)), ((0, 0), (0, 1))))
    naming = assign_markers(
        pixels + rng.normal(0, 0.05, (170, 2)),
        build_pattern(layout.positions, build_camera().project, place_orientation_mark(DOME, layout)),
    )
    held, refined = (register_dome(naming, layout, DOME, refine_lens=refine) for refine in (False, True))
    found, sd = refined.camera.spec, refined.lens_sd
    assert abs(found.fx_px / lens["fx_px"] - 1) < 3 * sd[0]
    assert np.all(np.abs([found.cx_px - 179.0, found.cy_px - 125.0]) < 3 * sd[1:])
    assert sd[0] < known
    assert found.fy_px / found.fx_px == pytest.approx(nominal.fy_px / nominal.fx_px)
    assert refined.held_rms_px == held.rms_px == held.held_rms_px
    assert refined.rms_px < held.rms_px
    assert held.camera.spec.cx_px == nominal.cx_px
    assert np.isnan(held.lens_sd).all()


def test_a_lens_that_the_image_cannot_tell_stays_as_calibrated():
    """Seven dots tell nine numbers from nothing: what the lens is held to decides."""
    layout = place_markers(DOME, MarkerSpec(count=7))
    mark = place_orientation_mark(DOME, layout)
    pixels = build_camera().project(np.vstack([layout.positions, mark])) + generator(1, "few").normal(0, 0.3, (8, 2))
    naming = assign_markers(pixels, build_pattern(layout.positions, build_camera().project, mark))
    found = register_dome(naming, layout, DOME, refine_lens=True).camera.spec
    assert found.fx_px == pytest.approx(CameraSpec().fx_px, rel=0.02)
    assert found.cx_px == pytest.approx(CameraSpec().cx_px, abs=5.0)


def test_a_mirrored_image_and_another_height_are_refused(predictor):
    with refused("image-mirrored"):
        open_sensor([photograph((0, 0, 0))[:, ::-1].copy()], Unit(Design.of_skin(DOME, LAYOUT)), predictor)
    flat = build_skin(DomeSpec(height=10))
    other = Unit(Design.of_skin(flat, place_markers(flat, MarkerSpec(count=91))))
    with refused(
        (
            "layout-misfit",
            "layout-misfit-rings",
            "layout-misfit-scale",
            "markers-not-assigned",
            "orientation-mark-unseen",
        )
    ):
        open_sensor([photograph((0, 0, 0))], other, predictor)


def test_a_model_of_another_design_is_refused(predictor):
    unit = Unit(Design.of_skin(DOME, place_markers(DOME, MarkerSpec(count=37))))
    with refused("model-marker-count", "91", "37"):
        open_sensor([photograph((0, 0, 0))], unit, predictor)


def test_without_images_or_dots_there_is_no_sensor(predictor):
    with refused("rest-image-missing"):
        open_sensor([], Unit(Design.of_skin(DOME, LAYOUT)), predictor)
    with refused("image-size-changed", "rest image 2 of 2", 100):
        images = [photograph((0, 0, 0)), np.zeros((100, 100), np.uint8)]
        open_sensor(images, Unit(Design.of_skin(DOME, LAYOUT)), predictor)
    with refused("markers-not-found", "rest image 1 of 2"):
        open_sensor([np.zeros((260, 346), np.uint8)] * 2, Unit(Design.of_skin(DOME, LAYOUT)), predictor)
    with refused("markers-not-found"):
        open_sensor([np.zeros((260, 346), np.uint8)], Unit(Design.of_skin(DOME, LAYOUT)), predictor)


def test_a_hidden_mark_is_not_guessed(predictor):
    points = LAYOUT.positions
    normals = (points - [0, 0, DOME.center_z]) / DOME.radius
    image = render(build_camera(), flat_marker_outlines(points, normals, LAYOUT.diameter))
    with refused("orientation-mark-unseen", "12"):
        open_sensor([image], Unit(Design.of_skin(DOME, LAYOUT)), predictor)
    assert open_sensor(
        [image], Unit(Design.of_skin(DOME, LAYOUT), has_orientation_mark=False), predictor
    ).assignment.ambiguous


def test_hostile_images_give_flagged_readings_and_the_next_is_read(predictor):
    sensor = opened(predictor)
    huge = np.lib.stride_tricks.as_strided(np.zeros(1, np.uint8), (20_000, 20_000), (0, 0))
    hostile = [
        np.zeros((260, 346), np.uint8),
        np.full((260, 346), 255, np.uint8),
        generator(0, "noise").integers(0, 255, (260, 346), dtype=np.uint8),
        np.zeros((1, 1), np.uint8),
        np.zeros((100, 100), np.uint8),
        huge,
        PalpateError("cut.png cannot be decoded.", code="image-damaged"),
    ]
    readings = list(run_sensor(sensor, hostile))
    assert all(reading.flags for reading in readings)
    assert all(np.isnan(reading.depth_mm) for reading in (readings[0], readings[1], *readings[3:]))
    assert readings[-1].reason == "cut.png cannot be decoded."
    after = sensor.read(photograph((2.0, 1.0, 1.0)))
    assert after.found == 91


def test_several_rest_images_are_averaged(predictor):
    images = [photograph((0, 0, 0), seed=k, noise=6.0, blur_px=0.7) for k in range(8)]
    true = build_camera().project(LAYOUT.positions)
    alone = open_sensor(images[:1], Unit(Design.of_skin(DOME, LAYOUT)), predictor)
    together = open_sensor(
        images, Unit(Design.of_skin(DOME, LAYOUT)), predictor, SensorSpec(), DetectSpec(polarity="dark")
    )
    error = [np.std(sensor.assignment.positions_px - true) for sensor in (alone, together)]
    assert error[1] < error[0]


def test_motion_outside_the_training_is_flagged_only_while_touched(predictor):
    class Outside:
        markers, level, space = 91, 0.9, TILT_SPACE

        def predict(self, images_px):
            return Prediction(np.zeros((1, 3)), np.ones((1, 3)), np.ones(1, bool))

    sensor = open_sensor([photograph((0, 0, 0))], Unit(Design.of_skin(DOME, LAYOUT)), Outside())
    assert sensor.read(photograph((0, 0, 0))).flags == ()
    assert sensor.read(photograph((0, 0, 4.0))).flags == (Flag.OUT_OF_DISTRIBUTION,)
    assert predictor.level is None


@pytest.mark.parametrize("suffix", ["csv", "jsonl"])
def test_readings_are_written_as_they_come(predictor, tmp_path, suffix):
    sensor = opened(predictor)
    path = tmp_path / f"out.{suffix}"
    images = [photograph((1, 1, 2.0)), PalpateError("gone.", code="source-gone")]
    readings = list(write_readings(path, run_sensor(sensor, images)))
    text = path.read_text().splitlines()
    rows = list(csv.DictReader(text)) if suffix == "csv" else [json.loads(line) for line in text]
    assert float(rows[0]["depth_mm"]) == pytest.approx(readings[0].depth_mm)
    assert rows[1]["depth_mm"] in ("", None)
    assert rows[1]["reason"] == "gone."
    assert describe_reading(readings[1])["depth_half_width_mm"] is None


def test_a_file_of_another_kind_is_refused(tmp_path):
    with refused("file-ending-unknown"):
        list(write_readings(tmp_path / "out.txt", []))


@pytest.mark.parametrize("count", [37, 91])
@pytest.mark.parametrize("teeth", [12, 24, 40, 60])
def test_dots_before_a_bright_toothed_rim_are_named(count, teeth):
    """Where the rim's own dots outnumber the printed ones, the design's size tells which are meant."""
    layout = place_markers(DOME, MarkerSpec(count=count))
    printed = np.vstack([layout.positions, place_orientation_mark(DOME, layout)])
    normals, camera = DOME.normal(printed), build_camera()
    truth, middle = camera.project(printed), (camera.spec.cx_px, camera.spec.cy_px)
    edges, outermost = (
        flat_marker_outlines(printed, normals, layout.diameter),
        np.linalg.norm(truth - middle, axis=1).max(),
    )
    for seed in range(4):
        image = render(camera, edges, RenderSpec(seed=seed, noise=2.0, blur_px=0.8, vignetting=0.3))
        image = toothed_rim(image, middle, outermost + 6.0 + 2.0 * seed, 4.0 + 3.0 * seed, 90.0, teeth, seed)
        naming = analyse_rest([image], Unit(Design.of_skin(DOME, layout, CameraSpec()))).naming
        assert naming.found.all()
        assert not naming.ambiguous
        assert np.linalg.norm(naming.positions_px - truth[:-1], axis=1).max() < 0.5
