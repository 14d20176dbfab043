import numpy as np
import pytest

from palpate.core import PalpateError
from palpate.design import OFFSET_DEPTH, TILT_DEPTH, PoseSpace
from palpate.fea import BallSpec, WallSpec


@pytest.mark.parametrize("space", [TILT_DEPTH, OFFSET_DEPTH])
def test_a_space_is_found_by_the_names_of_its_components(space):
    assert PoseSpace.named(list(space.names)) is space


def test_a_pose_of_another_package_is_read_by_its_names():
    space = PoseSpace.named(["across_mm", "along_mm", "depth_mm"])
    assert [(item.axis, item.unit) for item in space.components] == [
        ("across", "mm"),
        ("along", "mm"),
        ("depth", "mm"),
    ]
    assert not space.tilts


@pytest.mark.parametrize("names", [["rx_deg"], ["a", "b", "c"]])
def test_names_of_no_pose_are_refused(names):
    with pytest.raises(PalpateError, match="No pose has the components"):
        PoseSpace.named(names)


@pytest.mark.parametrize(
    ("obstacle", "place"),
    [(WallSpec(tilt_deg=5.0, azimuth_deg=90.0), (0.0, 5.0)), (BallSpec(offset=3.0, azimuth_deg=90.0), (0.0, 3.0))],
)
def test_the_azimuth_of_an_obstacle_is_that_of_its_pose(obstacle, place):
    assert obstacle.pose_space.part(obstacle.radial, obstacle.turn_deg) == pytest.approx(place)


def test_an_error_is_the_length_in_the_first_two_components():
    assert OFFSET_DEPTH.error(np.array([[3.0, 4.0, 9.0]]), np.zeros((1, 3))) == pytest.approx([5.0])
