"""What a sensor carries from image to image is that of one reading an image, whatever else was tried."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from palpate.calibration import PoseFitter
from palpate.camera import CameraSpec, build_camera
from palpate.design import Design, DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import Press, WallSpec
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, mesh_skin
from palpate.sensor import Flag, Sensor, SensorSpec, Unit
from palpate.sensor.drift_filter import FRAME_S
from palpate.sensor.pose_estimator import ReaderState, TwinEstimator
from palpate.sensor.reading import Reading
from palpate.surrogate import TWIN_DERIVATIVES, Twin
from palpate.vision import MarkerAssignment, TrackedMarkers
from presses import build_twin, solve_press

DOME = build_skin(DomeSpec(height=20, thickness=2))
LAYOUT = place_markers(DOME, MarkerSpec(count=91))
CAMERA = build_camera(CameraSpec())
NOISE = 0.02


def press(tilt_deg: float) -> Press:
    wall = WallSpec(tilt_deg=tilt_deg, contact="frictionless", depth=4.8, depth_step=0.6)
    mesh, solver = mesh_skin(DOME, MeshSpec(cells=8)), SolverSpec(derivatives=TWIN_DERIVATIVES, edge_share=1.0)
    return solve_press(mesh, get_material("zaid_2024_ecoflex_00_30"), wall, solver)


@pytest.fixture(scope="module")
def twin() -> Twin:
    return build_twin([press(tilt) for tilt in (0.0, 4.0, 8.0, 12.0)])


class Dots:
    """A detector of images that are dots (n, 2) already."""

    def __init__(self, positions_px: np.ndarray) -> None:
        self.positions_px = positions_px

    def find(self, image: np.ndarray) -> "Dots":
        return Dots(image)


def images(twin: Twin) -> list[np.ndarray]:
    """A camera that drifts for a while, then a touch that goes down and comes back."""
    rng, moved = np.random.default_rng(3), twin.with_markers(LAYOUT.positions)
    depths = [0.0] * 40 + [1.0, 1.9, 2.8, 3.7, 2.8, 1.0] + [0.0] * 5
    points = [moved.evaluate(np.array([3.0, -2.0, z]), 0.0).positions if z else LAYOUT.positions for z in depths]
    shown = [CAMERA.project(each) + np.array([0.002 * min(k, 40), 0.0]) for k, each in enumerate(points)]
    return [each + NOISE * rng.normal(size=each.shape) for each in shown]


def opened(twin: Twin, misfit: float) -> Sensor:
    rest = CAMERA.project(LAYOUT.positions)
    naming = MarkerAssignment(np.arange(len(rest)), rest, np.ones(len(rest), bool), 0.0, False, (), -1, 0.0)
    unit = Unit(Design.of_skin(DOME, LAYOUT, CameraSpec()))
    spec = SensorSpec(noise_px=NOISE).model_copy(update={"misfit": misfit})  # also one that every image exceeds
    return Sensor(unit, TwinEstimator(twin, unit, naming, spec), spec, Dots(rest), naming, None)


def test_a_rejected_second_reading_leaves_no_trace(twin: Twin, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every image counts as a misfit; the second reading has other dots, and is made to fit worse."""
    offered, control = opened(twin, 1e-6), opened(twin, 1e-6)
    foresee, read, tried = TwinEstimator.predict_markers, TwinEstimator.estimate, []

    def without_some(reader: TwinEstimator, estimate: Reading) -> np.ndarray | None:
        if reader is control.estimator:
            return None
        foreseen = foresee(reader, estimate)
        foreseen[np.nansum((foreseen - seen) ** 2, axis=1).argsort()[:5]] += 1000.0
        tried.append(foreseen)
        return foreseen

    def worse(*given: object, **words: object) -> tuple[Reading, ReaderState]:
        estimate, state = read(*given, **words)
        if len(given) > 3:
            estimate = replace(estimate, fit=replace(estimate.fit, misfit=np.inf))
        return estimate, state

    monkeypatch.setattr(TwinEstimator, "predict_markers", without_some)
    monkeypatch.setattr(TwinEstimator, "estimate", worse)
    for seen in images(twin):
        first, second = offered.read(seen), control.read(seen)
        assert np.array_equal(first.pose, second.pose)
        assert np.array_equal(first.half_width, second.half_width)
        assert first.rest == second.rest
        assert np.array_equal(first.sighting.positions_px, second.sighting.positions_px)
    assert len(tried) == len(images(twin))
    assert second.rest.rms_px > 0.03


@pytest.mark.parametrize("error", [np.linalg.LinAlgError("singular"), cv2.error("size"), ZeroDivisionError("0")])
@pytest.mark.parametrize("place", ["follow", "find"])
def test_an_image_that_breaks_a_library_costs_its_own_reading_only(
    twin: Twin, monkeypatch: pytest.MonkeyPatch, error: Exception, place: str
) -> None:
    """Readings after it are those of a sensor that was not given it."""

    def fail(*_: object) -> None:
        raise error

    broken, control = opened(twin, 5.0), opened(twin, 5.0)
    for number, seen in enumerate(images(twin)[36:44]):
        if number == 5:
            with monkeypatch.context() as patch:
                patch.setattr(*((PoseFitter, "follow") if place == "follow" else (Dots, "find")), fail)
                reading = broken.read(seen)
            assert reading.flags == (Flag.UNREADABLE,)
            assert np.isnan(reading.pose).all()
            assert np.isinf(reading.half_width).all()
            assert type(error).__name__ in reading.reason
        else:
            first, second = broken.read(seen), control.read(seen)
            assert np.array_equal(first.pose, second.pose)
            assert first.rest == second.rest


def test_a_clock_tells_how_fast_the_camera_drifts(twin: Twin) -> None:
    """Images at the nominal rate are followed as without a clock; slower ones, of the same drift, at a lower pace."""
    paces = []
    for step_s in (None, FRAME_S, 4 * FRAME_S):
        sensor, time = opened(twin, 5.0), [0.0]
        for seen in images(twin)[:40]:
            time[0] += step_s or 0.0
            sensor.clock = None if step_s is None else lambda time=time: time[0]
            sensor.read(seen)
        paces.append(sensor._state.reader.rest.drift.mean[:, 1])
    assert paces[1] == pytest.approx(paces[0], rel=1e-6)
    assert np.linalg.norm(paces[2]) < 0.6 * np.linalg.norm(paces[1])


def test_a_second_fit_of_one_image_keeps_the_motion_of_the_touch(twin: Twin) -> None:
    """Drift is taken out again where the touch has moved far: the wall still goes on from image to image."""
    reader = opened(twin, 5.0).estimator
    state = reader.begin()
    for dots in images(twin)[:44]:
        everything = np.ones(len(dots), bool)
        _, state = reader.estimate(TrackedMarkers(dots, everything, np.arange(len(dots)), False), state)
    assert state.rest.motion.rms_px > 0.03
    assert state.fit.flat.motion["depth_mm"] == pytest.approx(0.9, abs=0.05)
