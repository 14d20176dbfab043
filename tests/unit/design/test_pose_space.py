import numpy as np
import pytest

from errors import refused
from palpate.design import OFFSET_SPACE, TILT_SPACE, PoseSpace
from palpate.fea import BallSpec, CylinderSpec, WallSpec
from palpate.fea.edge import EdgeSpec

LINES = PoseSpace.for_lines()


@pytest.mark.parametrize("space", [TILT_SPACE, OFFSET_SPACE, LINES])
def test_a_space_is_found_by_the_names_of_its_components(space):
    assert PoseSpace.from_names(list(space.names)) is space


def test_a_pose_of_another_package_is_read_by_its_names():
    space = PoseSpace.from_names(["across_mm", "along_mm", "depth_mm"])
    assert [(item.axis, item.unit) for item in space.components] == [
        ("across", "mm"),
        ("along", "mm"),
        ("depth", "mm"),
    ]
    assert not space.is_tilt


@pytest.mark.parametrize("names", [["rx_deg"], ["a", "b", "c"]])
def test_names_of_no_pose_are_refused(names):
    with refused("pose-components-unknown"):
        PoseSpace.from_names(names)


@pytest.mark.parametrize(
    ("obstacle", "place"),
    [(WallSpec(tilt_deg=5.0, azimuth_deg=90.0), (0.0, 5.0)), (BallSpec(offset=3.0, azimuth_deg=90.0), (0.0, 3.0))],
)
def test_the_azimuth_of_an_obstacle_is_that_of_its_pose(obstacle, place):
    assert obstacle.pose_space.cartesian(obstacle.radial, obstacle.turn_deg) == pytest.approx(place)


def test_an_error_is_the_length_in_the_first_two_components():
    assert OFFSET_SPACE.error(np.array([[3.0, 4.0, 9.0]]), np.zeros((1, 3))) == pytest.approx([5.0])


@pytest.mark.parametrize("kind", [CylinderSpec, EdgeSpec])
@pytest.mark.parametrize(("offset", "azimuth_deg"), [(2.0, 30.0), (-3.0, 80.0), (0.0, -45.0), (1.0, 135.0)])
def test_a_line_has_one_pose_from_either_side(kind, offset, azimuth_deg):
    """Offset by 2 mm at 30° it is the line offset by -2 mm at 210°; its pose tells where the obstacle stands."""
    there, back = kind(offset=offset, azimuth_deg=azimuth_deg), kind(offset=-offset, azimuth_deg=azimuth_deg + 180)
    poses = [line.pose_space.pose(line.radial, line.turn_deg, 1.0) for line in (there, back)]
    assert poses[0] == pytest.approx(poses[1], abs=1e-12)
    found, angle = LINES.line(poses[0])
    half_turns = round((angle - azimuth_deg) / 180)
    assert angle == pytest.approx(azimuth_deg + 180 * half_turns)
    assert found == pytest.approx(offset * (-1) ** half_turns)
    direction = np.radians(azimuth_deg)
    assert poses[0][:2] == pytest.approx([-offset * np.sin(direction), offset * np.cos(direction)])


def test_poses_of_drawn_lines_are_those_of_their_obstacles():
    pose = LINES.pose(2.0, 30.0, 1.5)
    assert LINES.poses(pose[None, :2], np.array([1.5]))[0] == pytest.approx(pose)
    assert TILT_SPACE.poses(np.array([[1.0, 2.0]]), np.array([3.0])).tolist() == [[1.0, 2.0, 3.0]]


def test_a_line_read_beyond_a_quarter_turn_is_as_far_off_as_it_lies():
    true, found = LINES.pose(2.0, 89.0, 1.0), LINES.pose(-2.1, -88.0, 1.2)
    assert LINES.line_error(found, true) == pytest.approx([0.1, 3.0])
    assert LINES.line_error(true, true) == pytest.approx([0.0, 0.0])
    near = LINES.pose(2.0, 89.5, 1.0)
    assert np.linalg.norm((near - true)[3:]) == pytest.approx(0.5, rel=1e-3)


def test_a_wall_has_no_line():
    with refused("pose-not-line", "rx_deg", "ry_deg", "depth_mm"):
        TILT_SPACE.line([0.0, 0.0, 1.0])
