"""Cones, splines and walls that taper, held against other skins, closed forms and differences."""

import numpy as np
import pytest

from errors import refused
from palpate.design import CadSolid, ConeSpec, Dome, Rim, SplineSpec, revolve, skin_from_data
from palpate.design.cone import Cone
from palpate.design.ellipsoid import Ellipsoid
from palpate.design.revolved import RevolvedSkin

FINGER = Cone(30.0, 10.0, 1.0, 0.0, 10.0)
SPECS = [
    ConeSpec(height=22, base_radius=15, edge_radius=6, taper=0.7),
    ConeSpec(height=20, base_radius=14, flat_radius=5, edge_radius=5),
    SplineSpec(height=16, base_radius=20, points=((0.5, 0.9), (0.85, 0.5)), taper=1.4),
]


def across(skin: RevolvedSkin, count: int = 2001) -> np.ndarray:
    t = np.linspace(0.0, 1.0, count)
    return skin.point(np.column_stack([t, 0 * t]), 0.0)[:, [0, 2]]


def volume(meridian: np.ndarray) -> float:
    """Of the body between the base plane and a meridian (n, 2) turned about the axis, mm³."""
    x, z = meridian.T
    return float(np.pi * np.trapezoid((x[:-1] ** 2 + x[1:] ** 2) / 2, (z[0] - z[:-1])))


def wall_of(skin: RevolvedSkin) -> CadSolid:
    """The wall by the CAD kernel."""
    outer = skin.meridian(skin.thickness, down=True)
    return revolve([(0.0, skin.outer_height), *outer, (skin.base_radius, 0.0), *skin.meridian(0.0, down=False)])


def test_a_cone_whose_edge_is_the_whole_meridian_is_the_dome() -> None:
    dome = Dome(12.0, 20.0, 2.0)
    cone = Cone(12.0, 20.0, 2.0, 0.0, dome.radius)
    place = np.random.default_rng(1).uniform(-0.7, 0.7, (100, 2))
    for layer in (0.0, 1.0):
        expected = dome.point(place, layer, Rim.RADIAL)
        assert cone.point(place, layer, Rim.RADIAL) == pytest.approx(expected, abs=1e-6)
    assert cone.support_point(np.array([0.0, 0.1, np.sqrt(0.99)])) == pytest.approx(
        dome.support_point(np.array([0.0, 0.1, np.sqrt(0.99)])), abs=1e-6
    )


def test_a_finger_is_a_cylinder_with_half_a_ball() -> None:
    x, z = across(FINGER).T
    low = z < 20
    assert x[low] == pytest.approx(10.0)
    assert x[~low] ** 2 + (z[~low] - 20) ** 2 == pytest.approx(100.0)
    assert not FINGER.bulges
    ball, bar = 2 / 3 * np.pi * np.array([10.0, 11.0]) ** 3, np.pi * 20 * np.array([10.0, 11.0]) ** 2
    assert wall_of(FINGER).volume == pytest.approx(float(np.diff(ball + bar)[0]), rel=1e-6)


def test_a_flat_tip_is_flat_and_its_flank_straight_and_square_to_the_edge() -> None:
    skin = ConeSpec(height=20, base_radius=14, flat_radius=5, edge_radius=5).build()
    meridian = across(skin)
    assert meridian[meridian[:, 0] <= 5][:, 1] == pytest.approx(20.0)
    turn = np.unwrap(np.arctan2(*np.diff(meridian, axis=0).T[::-1]))
    assert np.abs(np.diff(turn)).max() < 0.01
    tangent = meridian[-1] - meridian[-200]
    centre = np.array([5.0, 15.0]) - meridian[-1]
    assert abs(tangent[0] * centre[1] - tangent[1] * centre[0]) / np.hypot(*tangent) == pytest.approx(5.0)


def test_a_spline_through_an_ellipse_is_nearly_the_ellipsoid() -> None:
    ellipsoid = Ellipsoid(18.0, 20.0, 2.0, 0.9)
    knots = across(ellipsoid, 9)[1:-1] / [20.0, 18.0]
    skin = SplineSpec(height=18, base_radius=20, thickness=2, points=tuple(map(tuple, knots))).build()
    points = skin.point(np.column_stack([np.linspace(0, 1, 50), np.zeros(50)]), 0.0)
    assert np.abs(ellipsoid.distance(points)).max() < 0.02
    assert skin.radius == pytest.approx(ellipsoid.radius, rel=0.02)


def test_a_wall_that_tapers_is_as_thick_as_it_says_and_is_read_again() -> None:
    skin = Ellipsoid(20.0, 20.0, 2.0, 1.0, taper=1.5)
    disc = np.column_stack([np.linspace(0, 1, 11), np.zeros(11)])
    wall = np.linalg.norm(skin.point(disc, 1.0, Rim.RADIAL) - skin.point(disc, 0.0), axis=1)
    assert wall == pytest.approx(2.0 * (1 + 0.5 * disc[:, 0] ** 2))
    assert skin.name == "ellipsoid 1 H20 T2 taper 1.5"
    assert skin_from_data(skin.spec_data).build() == skin
    assert "taper" not in Ellipsoid(20.0, 20.0, 2.0, 1.0).spec_data
    assert skin.outer_widest[0] == pytest.approx(23.0, abs=0.2)


def test_the_radius_at_the_apex_is_finite_also_where_it_is_flat() -> None:
    assert ConeSpec(height=20, base_radius=14, flat_radius=5, edge_radius=5).build().radius == 5.0
    broad = SplineSpec(points=((0.5, 0.995), (0.9, 0.5))).build()
    assert 3.0 < broad.radius < 20.0


@pytest.mark.parametrize("spec", SPECS, ids=lambda spec: spec.build().name)
@pytest.mark.parametrize("tilt", [1.0, 8.0])
def test_a_wall_touches_the_outermost_point(spec, tilt: float) -> None:
    """By brute force over points of the outer surface, finer than a table that the code could have."""
    skin = spec.build()
    normal = np.array([np.sin(np.radians(tilt)), 0.0, np.cos(np.radians(tilt))])
    s = np.linspace(0, 1, 200_001)
    outer = skin.point(np.column_stack([s, 0 * s]), 1.0)
    assert skin.support_point(normal) @ normal == pytest.approx((outer @ normal).max(), abs=1e-8)
    slope = outer[-1] - outer[-2]
    assert skin.rim_slope(Rim.FLAT) == pytest.approx(np.arctan2(-slope[2], slope[0]), abs=1e-3)


@pytest.mark.parametrize("spec", SPECS, ids=lambda spec: spec.build().name)
def test_the_solid_of_a_skin_has_the_volume_between_its_surfaces(spec) -> None:
    """The CAD kernel's volume, against Pappus' rule over the meridians."""
    skin = spec.build()
    s = np.linspace(0, 1, 4001)
    disc = np.column_stack([s, 0 * s])
    between = volume(skin.point(disc, 1.0)[:, [0, 2]]) - volume(skin.point(disc, 0.0)[:, [0, 2]])
    assert wall_of(skin).volume == pytest.approx(between, rel=2e-3)


@pytest.mark.parametrize(
    ("data", "says"),
    [
        ({"kind": "cone", "height": 10, "base_radius": 15, "edge_radius": 30}, ("cone-edge-outside-rim",)),
        ({"kind": "spline", "points": [[0.5, -0.1]]}, ("point-not-over-base",)),
        ({"kind": "spline", "points": [[0.2, 0.05], [0.9, 0.9], [0.95, 0.05]]}, ("meridian-too-hollow",)),
        (
            {"kind": "spline", "thickness": 8, "points": [[0.3, 0.95], [0.5, 0.4], [0.8, 0.25]]},
            ("meridian-too-hollow",),
        ),
        ({"kind": "spline", "points": "0.5"}, ("points-as-words",)),
        ({"kind": "ellipsoid", "taper": 9}, ("less_than_equal", "3")),
    ],
)
def test_shapes_that_cannot_be_are_refused(data: dict, says: tuple[str, ...]) -> None:
    with refused(*says):
        skin_from_data(data).build()
