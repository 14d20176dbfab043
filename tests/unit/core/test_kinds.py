"""Specs by kind: what is written wrongly is one sentence that names it, for skins and obstacles alike."""

import pytest

from palpate.core import PalpateError
from palpate.design import DomeSpec, EllipsoidSpec, read_skin
from palpate.fea import BallSpec, WallSpec, read_obstacle


def test_words_keep_the_sizes_and_the_travel_of_the_flags() -> None:
    assert read_skin("ellipsoid:aspect=0.8", DomeSpec(height=15)) == EllipsoidSpec(height=15, aspect=0.8)
    assert read_skin("dome", DomeSpec(height=15)) == DomeSpec(height=15)
    assert read_obstacle("wall", WallSpec(tilt_deg=5, depth=3)) == WallSpec(tilt_deg=5, depth=3)
    assert read_obstacle("ball:radius=4", WallSpec(tilt_deg=5, depth=3)) == BallSpec(radius=4, depth=3)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("cone", "There is no obstacle 'cone'"),
        ("ball:radius", "not written as KIND:NAME=VALUE"),
        ("ball:radius=-1", "obstacle's radius"),
        ("ball:weight=2", "obstacle's weight"),
        ("wall:tilt_deg=99", "obstacle's tilt_deg"),
    ],
)
def test_a_wrong_obstacle_is_refused_with_its_number_named(text: str, says: str) -> None:
    with pytest.raises(PalpateError, match=says):
        read_obstacle(text, WallSpec())


@pytest.mark.parametrize(
    "text", ["pyramid", "ellipsoid:aspect", "ellipsoid:aspect=9", "ellipsoid:weight=1", "dome:aspect=1"]
)
def test_a_wrong_skin_is_refused(text: str) -> None:
    with pytest.raises(PalpateError, match="skin"):
        read_skin(text, DomeSpec())
