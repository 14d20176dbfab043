"""Numbers decided by a press of known pose, where the print has no mark."""

from dataclasses import replace

import numpy as np
import pytest

from errors import refused
from palpate.camera import CameraSpec, RenderSpec, build_camera, flat_marker_outlines, render
from palpate.core import generator
from palpate.design import Design, MarkerSpec, build_skin, place_markers
from palpate.sensor import ReferencePress, Unit
from palpate.sensor.reference_press import disambiguate
from palpate.sensor.sensor import analyse_rest
from palpate.vision import assign_markers, build_pattern, disambiguate_by_press
from small_chain import DOME, MARKERS, solve

BUILT = build_skin(DOME)


@pytest.fixture(scope="module")
def steep():
    """Presses by a wall turned by 8°, without slip and on a slippery wall, 1 to 5 mm deep."""
    return solve(8.0), solve(8.0, contact=0.8)


def turned(press, azimuth_deg):
    return replace(press, obstacle=press.obstacle.model_copy(update={"azimuth_deg": azimuth_deg}))


def unit_of(count):
    return Unit(Design.of_skin(BUILT, place_markers(BUILT, MarkerSpec(count=count))), has_orientation_mark=False)


def mounted(rng):
    return build_camera(
        CameraSpec(
            offset_x=rng.uniform(-2, 2),
            offset_y=rng.uniform(-2, 2),
            distance=rng.uniform(47, 49),
            tilt_x_deg=rng.uniform(-4, 4),
            tilt_y_deg=rng.uniform(-4, 4),
            roll_deg=rng.uniform(-180, 180),
        )
    )


def seen_dots(camera, points, rng, mirror=False, lost=0.05):
    """Dots (n, 2) in random order, and the number of the dot of each point, -1 where it is lost."""
    pixels = camera.project(points) + rng.normal(0, 0.05, (len(points), 2))
    pixels = (pixels - [345.0, 0.0]) * [-1.0, 1.0] if mirror else pixels
    there = rng.permutation(np.flatnonzero(rng.random(len(points)) >= lost))
    truth = np.full(len(points), -1)
    truth[there] = np.arange(len(there))
    return pixels[there], truth


def right(naming, truth):
    return not np.any((truth >= 0) & (naming.blob != truth))


def ask(unit, press, simulated, rng, mirror=False):
    """The fit to the deepest image of a press but one, where another press is simulated, and the truth at rest."""
    camera, points = mounted(rng), press.positions(unit.design.layout.positions)
    rest, truth = seen_dots(camera, points[0], rng, mirror)
    pressed, _ = seen_dots(camera, points[-2], rng, mirror)
    naming = assign_markers(rest, build_pattern(unit.design.layout.positions, build_camera().project))
    assert naming.ambiguous
    return disambiguate(naming, pressed, simulated.positions(unit.design.layout.positions)[-1], unit), truth


@pytest.mark.parametrize("count", [37, 91, 169])
@pytest.mark.parametrize("draw", range(4))
def test_a_slanted_press_tells_the_numbers_whatever_the_camera_friction_and_depth(steep, count, draw):
    rng, mirror = generator(draw, "known press", count), bool(draw % 2)
    azimuth = 60.0 * draw + 14.0
    fit, truth = ask(unit_of(count), turned(steep[1], azimuth), turned(steep[0], azimuth), rng, mirror)
    assert not fit.naming.ambiguous
    assert right(fit.naming, truth)
    assert fit.naming.mirrored == mirror
    assert 0.55 < fit.gain < 0.85  # 4 mm were pressed, 5 mm were given


@pytest.mark.parametrize("azimuth", [0.0, 30.0])
def test_a_press_towards_or_between_rows_leaves_the_mirror_open(steep, azimuth):
    press = turned(steep[0], azimuth)
    fit, truth = ask(unit_of(91), press, press, generator(3, "row"))
    assert [fit.naming.mirrored, *(other.mirrored for other in fit.naming.alternatives)].count(True) == 1
    assert any(right(naming, truth) for naming in (fit.naming, *fit.naming.alternatives))


def test_a_straight_press_tells_nothing():
    press = solve(0.0)
    fit, _ = ask(unit_of(91), press, press, generator(0, "straight"))
    assert len(fit.naming.alternatives) == 11


def test_another_press_than_was_given_is_refused(steep):
    unit, camera = unit_of(37), build_camera()
    points = steep[0].positions(unit.design.layout.positions)
    naming = assign_markers(camera.project(points[0]), build_pattern(unit.design.layout.positions, camera.project))
    for dots in (camera.project(points[0]), np.empty((0, 2))):
        with refused("reference-press-unexplained"):
            disambiguate(naming, dots, points[-1], unit)
    with refused("reference-press-too-light", "0.00"):
        disambiguate_by_press(naming, np.zeros((12, 37, 2)), camera.project(points[-1]), 20.0)


def test_an_image_of_a_known_press_opens_a_sensor_without_a_mark():
    layout = place_markers(BUILT, MARKERS)
    unit, camera = Unit(Design.of_skin(BUILT, layout)), build_camera(CameraSpec(roll_deg=70.0, tilt_x_deg=1.0))

    def photograph(points):
        normals = (layout.positions - [0, 0, BUILT.center_z]) / BUILT.radius
        return render(
            camera, flat_marker_outlines(points, normals, layout.diameter), RenderSpec(noise=2.0, blur_px=0.7)
        )

    rest, pressed = photograph(layout.positions), photograph(turned(solve(8.0), 15.0).positions(layout.positions)[-1])
    with refused("orientation-mark-unseen", "12"):
        analyse_rest([rest], unit)
    slanted = (8.0 * np.cos(np.radians(15.0)), 8.0 * np.sin(np.radians(15.0)), 5.0)
    found = analyse_rest([rest], unit, reference_press=ReferencePress.simulate(pressed, slanted, unit.design))
    assert found.registration.camera.spec.roll_deg == pytest.approx(70.0, abs=0.2)
    along = photograph(turned(solve(8.0), 0.0).positions(layout.positions)[-1])
    known = ReferencePress.simulate(along, (8.0, 0.0, 5.0), unit.design)
    with refused("assignment-ambiguous", "2"):
        analyse_rest([rest], unit, reference_press=known)


def test_a_press_without_depth_is_refused():
    with refused("press-depth-not-positive", "0"):
        ReferencePress.simulate(np.zeros((9, 9)), (5.0, 0.0, 0.0), unit_of(37).design)
