"""A sensor that reads for hours: the untouched dots are followed where they creep, never where they are touched."""

from dataclasses import dataclass, field

import numpy as np
import pytest

from palpate.camera import CameraSpec, build_camera
from palpate.design import Design, DomeSpec, MarkerLayout, MarkerSpec, build_skin, place_markers
from palpate.fea import Press, WallSpec
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, mesh_skin
from palpate.sensor import Flag, SensorSpec, Unit
from palpate.sensor.pose_estimator import TwinEstimator
from palpate.sensor.reading import Reading
from palpate.sensor.rest_drift import RestDrift
from palpate.surrogate import TWIN_DERIVATIVES, Twin
from palpate.vision import MarkerAssignment, TrackedMarkers
from presses import build_twin, solve_press

DOME = build_skin(DomeSpec(height=20, thickness=2))
LAYOUT = place_markers(DOME, MarkerSpec(count=91))
FEW = place_markers(DOME, MarkerSpec(count=37, ring_diameters=(4.1, 18.9, 31.1)))
NOISE = 0.02
NOMINAL = CameraSpec()
PRESSED = np.array([4.0, -3.0, 4.0])


def press(tilt_deg: float) -> Press:
    wall = WallSpec(tilt_deg=tilt_deg, contact="frictionless", depth=4.8, depth_step=0.6)
    mesh, solver = mesh_skin(DOME, MeshSpec(cells=8)), SolverSpec(derivatives=TWIN_DERIVATIVES, edge_share=1.0)
    return solve_press(mesh, get_material("zaid_2024_ecoflex_00_30"), wall, solver)


@pytest.fixture(scope="module")
def twin() -> Twin:
    return build_twin([press(tilt) for tilt in (0.0, 4.0, 8.0, 12.0)])


@dataclass
class Drawn:
    """A unit as designed, whose dots are drawn as its camera sees them."""

    twin: Twin
    camera: CameraSpec = NOMINAL
    layout: MarkerLayout = LAYOUT
    aside_px: tuple[float, float] = (0.0, 0.0)
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(5))

    def dots(self, pose: np.ndarray | None = None, noise: float = NOISE) -> np.ndarray:
        printed = self.layout.positions
        points = printed if pose is None else self.twin.with_markers(printed).evaluate(pose, 0.0).positions
        shown = build_camera(self.camera).project(points) + self.aside_px
        return shown + noise * self.rng.normal(size=shown.shape)

    def open(self, images: int = 20, **chosen: float) -> "Following":
        rest = np.mean([self.dots() for _ in range(images)], axis=0)
        numbers = np.arange(len(rest))
        naming = MarkerAssignment(numbers, rest, np.ones(len(rest), bool), 0.0, False, (), -1, 0.0)
        unit = Unit(Design.of_skin(DOME, self.layout, self.camera))
        return Following(TwinEstimator(self.twin, unit, naming, SensorSpec(noise_px=NOISE, **chosen)))

    def drift(self, way: str, share: float) -> None:
        """Move camera or silicone by a share of half a pixel or so."""
        if way == "the image shifts":
            self.aside_px = 0.4 * share, 0.3 * share
        elif way == "the camera leans":
            self.camera = moved(tilt_x_deg=0.15 * share, offset_y=0.05 * share)
        else:
            scale = 1 + 0.008 * share
            self.camera = moved(fx_px=scale * NOMINAL.fx_px, fy_px=scale * NOMINAL.fy_px)


def moved(**changes: float) -> CameraSpec:
    return NOMINAL.model_copy(update=changes)


class Following:
    """A reader with its state after the last image."""

    def __init__(self, reader: TwinEstimator) -> None:
        self.estimator, self.state = reader, reader.begin()

    @property
    def rest(self) -> RestDrift:
        return self.state.rest.motion

    def read(self, sighting: TrackedMarkers) -> Reading:
        estimate, self.state = self.estimator.estimate(sighting, self.state)
        return estimate


def read(reader: Following, dots: np.ndarray) -> Reading:
    return reader.read(TrackedMarkers(dots, np.ones(len(dots), bool), np.arange(len(dots)), False))


def read_pressed(reader: Following, unit: Drawn) -> np.ndarray:
    return read(reader, unit.dots(PRESSED, noise=0.0)).pose


@pytest.mark.parametrize("way", ["the image shifts", "the camera leans", "the silicone swells"])
def test_a_slow_drift_is_followed_and_poses_stay_right(twin: Twin, way: str) -> None:
    unit = Drawn(twin)
    reader, forgetful = unit.open(), unit.open(follow_px=0.0)
    before = read_pressed(reader, unit)
    for number in range(200):
        unit.drift(way, number / 200)
        assert Flag.CAMERA_MOVED not in read(reader, unit.dots(None if number % 10 else PRESSED)).flags
    assert reader.rest.rms_px == pytest.approx(0.5, abs=0.2)
    off = read_pressed(reader, unit) - before
    assert np.abs(off[:2]).max() < 0.02
    assert abs(off[2]) < 0.02
    assert np.abs(read_pressed(forgetful, unit) - before).max() > 0.02
    read(forgetful, unit.dots())
    assert Flag.CAMERA_MOVED in read(forgetful, unit.dots()).flags


@pytest.mark.parametrize("depth", [0.05, 0.15, 0.4])
def test_a_light_touch_is_never_learnt_however_long_it_lasts(twin: Twin, depth: float) -> None:
    unit = Drawn(twin)
    reader, touch = unit.open(), np.array([2.0, 1.0, depth])
    seen = [read(reader, unit.dots(touch)).pose[2] for _ in range(200)]
    assert np.mean(seen[-50:]) == pytest.approx(np.mean(seen[:50]), abs=0.02)
    assert reader.rest.rms_px < 0.04


def test_a_knock_of_the_camera_is_said_at_once_and_until_it_is_undone(twin: Twin) -> None:
    unit = Drawn(twin)
    reader = unit.open()
    assert read(reader, unit.dots()).flags == ()
    unit.aside_px = 0.6, -0.3
    assert Flag.CAMERA_MOVED in read(reader, unit.dots()).flags
    assert Flag.CAMERA_MOVED in read(reader, unit.dots(PRESSED)).flags
    assert reader.rest.rms_px < 0.02
    unit.aside_px = 0.0, 0.0
    assert Flag.CAMERA_MOVED not in read(reader, unit.dots()).flags


def test_nothing_is_followed_further_than_is_asked(twin: Twin) -> None:
    unit = Drawn(twin)
    reader, flags = unit.open(follow_px=0.2), []
    for number in range(150):
        unit.aside_px = 3e-3 * number, 0.0
        flags.append(Flag.CAMERA_MOVED in read(reader, unit.dots()).flags)
    assert not any(flags[:50])
    assert flags[-1]
    assert reader.rest.rms_px <= 0.2


def test_what_moved_is_said_as_shift_turn_and_scale(twin: Twin) -> None:
    unit = Drawn(twin)
    reader = unit.open()
    for number in range(300):
        unit.camera = moved(roll_deg=0.2 * min(number / 150, 1.0))
        read(reader, unit.dots())
    assert abs(reader.rest.turn_deg) == pytest.approx(0.2, abs=0.01)
    assert reader.rest.scale == pytest.approx(1.0, abs=3e-4)
    assert np.abs(reader.rest.shift_px).max() < 0.03


def test_missing_dots_do_not_move_the_rest(twin: Twin) -> None:
    unit = Drawn(twin)
    reader = unit.open()
    for _ in range(60):
        dots, found = unit.dots(), unit.rng.random(len(LAYOUT)) > 0.1
        dots[~found] += 5.0
        reader.read(TrackedMarkers(dots, found, np.arange(len(dots)), False))
    assert reader.rest.rms_px < 0.03


@pytest.mark.parametrize("seed", [5, 6])
def test_few_dots_of_a_camera_that_never_moved_are_read_as_if_nothing_was_followed(twin: Twin, seed: int) -> None:
    unit = Drawn(twin, moved(distance=30.0), FEW, rng=np.random.default_rng(seed))
    watchful = unit.open(images=1)
    still = Following(
        TwinEstimator(
            twin,
            Unit(Design.of_skin(DOME, FEW, unit.camera)),
            MarkerAssignment(
                np.arange(37), watchful.estimator.watch.rest_px, np.ones(37, bool), 0.0, False, (), -1, 0.0
            ),
            SensorSpec(noise_px=NOISE, follow_px=0.0),
        )
    )
    for touch in range(16):
        azimuth = 0.4 * touch
        for depth in (0.0, 0.8, 1.6, 2.4, 3.2, 4.0, 4.8):
            pose = np.array([11.0 * np.cos(azimuth), 11.0 * np.sin(azimuth), depth])
            dots = unit.dots(pose if depth else None)
            seen, control = read(watchful, dots), read(still, dots)
            assert Flag.CAMERA_MOVED not in (*seen.flags, *control.flags)
            if depth:
                assert np.abs(seen.pose[:2] - control.pose[:2]).max() < 0.02
