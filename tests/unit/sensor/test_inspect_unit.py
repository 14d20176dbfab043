"""Print errors from rendered images of domes whose dots were misprinted by known amounts."""

import numpy as np
import pytest

from palpate.camera import CameraSpec, RenderSpec, build_camera, flat_marker_outlines, render
from palpate.core import generator
from palpate.design import Design, DomeSpec, MarkerSpec, build_skin, place_markers, place_orientation_mark
from palpate.sensor import InspectionSpec, Unit, inspect_unit

SEATED = CameraSpec(offset_x=0.3, offset_y=-0.2, distance=48.7, tilt_x_deg=0.6, tilt_y_deg=-0.4, roll_deg=12.0)
SPOILED = RenderSpec(vignetting=0.3, unevenness=0.2, blur_px=0.7, noise=2.0, dirt=5, rim=True)


def printed(unit, error):
    """Places of the dots that are off by (meridian, ring) mm, the mark after them."""
    points = unit.design.layout.positions
    rho = np.hypot(points[:, 0], points[:, 1])
    polar = np.arctan2(rho, points[:, 2] - unit.design.skin.center_z) + error[:, 0] / unit.design.skin.radius
    azimuth = np.arctan2(points[:, 1], points[:, 0]) + np.where(rho > 0, error[:, 1] / np.maximum(rho, 1e-9), 0)
    around = np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=-1)
    moved = unit.design.skin.radius * around + [0, 0, unit.design.skin.center_z]
    return np.vstack([moved, place_orientation_mark(unit.design.skin, unit.design.layout)])


def photograph(unit, places, camera=SEATED, light=SPOILED):
    normals = (places - [0, 0, unit.design.skin.center_z]) / unit.design.skin.radius
    return render(build_camera(camera), flat_marker_outlines(places, normals, unit.design.layout.diameter), light)


def unit_of(height, count):
    dome = build_skin(DomeSpec(height=height))
    return Unit(Design.of_skin(dome, place_markers(dome, MarkerSpec(count=count))))


@pytest.mark.parametrize("count", [7, 19])
def test_few_dots_are_read_where_their_design_is_known(count):
    """Seven markers are a layout of the paper."""
    unit = unit_of(20, count)
    image = photograph(unit, printed(unit, np.zeros((count, 2))), light=RenderSpec(seed=3))
    assert len(inspect_unit([image], unit).missing) == 0


@pytest.mark.parametrize(("height", "count"), [(10, 91), (20, 169), (30, 91)])
def test_the_print_error_of_every_marker_is_found(height, count):
    unit = unit_of(height, count)
    error = generator(0, "print").normal(0, 0.08, (count, 2))
    error[0] = 0.0  # at the apex meridian and ring are other directions
    inspection = inspect_unit([photograph(unit, printed(unit, error))], unit)
    assert not len(inspection.missing)
    left = inspection.error - error
    assert np.sqrt((left[1:] ** 2).mean()) < 0.02  # what is left is mostly the pose that the misprints pull along
    assert np.abs(left).max() < 0.08
    assert np.all(inspection.mm_per_px > 0.1)
    assert np.all(inspection.mm_per_px < 1.5)


def test_a_perfect_print_passes():
    unit = unit_of(20, 169)
    inspection = inspect_unit([photograph(unit, printed(unit, np.zeros((169, 2))))], unit)
    assert inspection.passed
    assert inspection.distance.max() < 0.05


def test_a_dot_out_of_place_and_one_not_printed_are_named():
    unit = unit_of(20, 91)
    error = np.zeros((91, 2))
    error[40] = 0.35, -0.2
    places = np.delete(printed(unit, error), 12, axis=0)
    inspection = inspect_unit([photograph(unit, places)], unit, InspectionSpec(tolerance=0.15))
    assert list(inspection.missing) == [12]
    assert list(inspection.outside) == [40]
    assert inspection.error[40] == pytest.approx(error[40], abs=0.03)
    assert not inspection.passed
    assert np.isnan(inspection.error[12]).all()
