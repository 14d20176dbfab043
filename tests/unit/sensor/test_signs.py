"""The sign of every axis, once: a wall is pressed a known way, and the image says where the dots went."""

from dataclasses import replace

import numpy as np
import pytest

from palpate.calibration import Deviation
from palpate.camera import CameraSpec, RenderSpec, build_camera
from palpate.core import FloatArray
from palpate.design import Design, build_skin, place_markers, wall_normal
from palpate.fea import Press, WallSpec
from palpate.mesh import MeshSpec, mesh_skin
from palpate.sensor import Placement, tilt_from_normal
from palpate.sensor.placement import rotation_between, rotation_from_vector
from palpate.simulation import SimulatedUnit
from presses import solve_press
from small_chain import DOME, MARKERS, MATERIAL

SKIN = build_skin(DOME)
TILT_DEG = 8.0


@pytest.fixture(scope="module")
def press() -> Press:
    wall = WallSpec(tilt_deg=TILT_DEG, depth=3.0, depth_step=1.5)
    return solve_press(mesh_skin(SKIN, MeshSpec(cells=8)), MATERIAL, wall)


def motion(press: Press, azimuth_deg: float, camera: CameraSpec) -> FloatArray:
    """Where the image of a press differs from that at rest: column and row from the middle of the dome, px."""
    scene = SimulatedUnit(Design.of_skin(SKIN, place_markers(SKIN, MARKERS), camera), Deviation(), RenderSpec())
    turned = replace(press, obstacle=press.obstacle.model_copy(update={"azimuth_deg": azimuth_deg}))
    images = [image.astype(float) for image in scene.render_press(turned)]
    changed = np.abs(images[-1] - images[0])
    rows, columns = np.indices(changed.shape)
    where = np.array([np.sum(columns * changed), np.sum(rows * changed)]) / changed.sum()
    return where - build_camera(camera).project([0.0, 0.0, 10.0])


def test_a_known_press_moves_the_dots_where_the_drawing_says(press: Press) -> None:
    """rx > 0 touches on the side of -y, the image's upper half; ry > 0 on the side of +x, its right half."""
    about_x, about_y = (motion(press, azimuth_deg, CameraSpec()) for azimuth_deg in (0.0, 90.0))
    assert about_x[1] < -3.0
    assert abs(about_x[0]) < 0.3 * abs(about_x[1])
    assert about_y[0] > 3.0
    assert abs(about_y[1]) < 0.3 * abs(about_y[0])
    assert press.obstacle.radial == TILT_DEG
    touched_first = SKIN.support_point(wall_normal(np.radians(TILT_DEG), 0.0))
    assert touched_first[1] < 0 < touched_first[2]
    assert (press.force[-1] @ wall_normal(np.radians(TILT_DEG), 0.0)) > 0, "the dome pushes along the normal"
    deepest = press.positions(SKIN.inner_point(np.zeros(1), np.zeros(1)))[:, 0, 2]
    assert deepest[-1] < deepest[0], "a depth above 0 moves the apex along -z"


def test_a_rolled_camera_shows_the_same_press_turned_the_other_way(press: Press) -> None:
    """roll > 0 turns the camera from x towards y, and its image from rows towards columns."""
    straight, rolled = (motion(press, 90.0, CameraSpec(roll_deg=roll)) for roll in (0.0, 30.0))
    turn = np.degrees(np.arctan2(rolled[1], rolled[0]) - np.arctan2(straight[1], straight[0]))
    assert turn == pytest.approx(-30.0, abs=6.0)


def test_columns_are_along_x_and_rows_along_y_of_the_sensor() -> None:
    middle, x, y, z = build_camera().project([[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 0, 10]])
    assert x[0] > middle[0]
    assert y[1] > middle[1]
    assert (x[1], y[0]) == pytest.approx((middle[1], middle[0]))
    nearer = build_camera().project([5, 0, 0])
    assert abs(z[0] - middle[0]) < abs(nearer[0] - middle[0]), "what goes towards the wall looks smaller"


def test_a_flange_turned_one_way_reads_the_wall_turned_the_other() -> None:
    """The sensor's axes along the flange's: turned by +5 degrees about its x before a square wall, rx is -5."""
    normal = np.array([0.0, 0.0, 1.0])
    for vector, tilt in (([5.0, 0, 0], [-5.0, 0]), ([0, 5.0, 0], [0, -5.0]), ([0, 0, 5.0], [0, 0])):
        base_from_sensor = Placement(rotation_from_vector(np.array(vector))) @ Placement(
            position=np.array([0, 0, 100.0])
        )
        assert tilt_from_normal(base_from_sensor.rotation.T @ normal) == pytest.approx(tilt, abs=1e-9)
    read = wall_normal(*np.radians([3.0, -2.0]))
    turned = rotation_between(normal, read)
    assert tilt_from_normal(turned.T @ read) == pytest.approx([0.0, 0.0], abs=1e-9), (
        "turned to what was read, it is square"
    )
    assert tilt_from_normal(turned[:, 2]) == pytest.approx([3.0, -2.0])
