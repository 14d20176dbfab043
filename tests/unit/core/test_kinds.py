"""Specs by kind: what is written wrongly is one sentence that names it, for skins and obstacles alike."""

import pytest

from errors import refused
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
        ("cone", ("kind-unknown", "obstacle", "cone")),
        ("ball:radius", ("kind-malformed", "obstacle", "ball:radius")),
        ("ball:radius=-1", ("greater_than", "obstacle", "radius")),
        ("ball:weight=2", ("extra_forbidden", "obstacle", "weight")),
        ("wall:tilt_deg=99", ("less_than_equal", "obstacle", "tilt_deg")),
    ],
)
def test_a_wrong_obstacle_is_refused_with_its_number_named(text: str, says: tuple[str, ...]) -> None:
    with refused(*says):
        read_obstacle(text, WallSpec())


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("pyramid", ("kind-unknown", "skin", "pyramid")),
        ("ellipsoid:aspect", ("kind-malformed", "skin", "ellipsoid:aspect")),
        ("ellipsoid:aspect=9", ("less_than_equal", "skin", "aspect")),
        ("ellipsoid:weight=1", ("extra_forbidden", "skin", "weight")),
        ("dome:aspect=1", ("extra_forbidden", "skin", "aspect")),
    ],
)
def test_a_wrong_skin_is_refused(text: str, says: tuple[str, ...]) -> None:
    with refused(*says):
        read_skin(text, DomeSpec())
