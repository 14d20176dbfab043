"""The ellipsoid held against the dome by another way, and the wall's normal against Rodrigues' rotation."""

import numpy as np
import pytest

from palpate.design import Dome, Rim, turn_about_axis, wall_normal
from palpate.design.ellipsoid import Ellipsoid
from palpate.design.revolved import RevolvedSkin

PAIRS = [(Dome(h, 20.0, t), Ellipsoid(h, 20.0, t, 1.0)) for h, t in ((10.0, 1.0), (20.0, 2.0), (30.0, 3.0))]


def disc(count: int = 200, largest: float = 1.0) -> np.ndarray:
    rng = np.random.default_rng(3)
    angle, radius = rng.uniform(0, 2 * np.pi, count), largest * np.sqrt(rng.uniform(0, 1, count))
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


@pytest.mark.parametrize(("dome", "ellipsoid"), PAIRS, ids=[dome.name for dome, _ in PAIRS])
def test_an_ellipsoid_of_aspect_one_is_the_dome(dome: Dome, ellipsoid: Ellipsoid) -> None:
    place = disc()
    for layer in (0.0, 0.5, 1.0):
        for rim in Rim:
            assert ellipsoid.point(place, layer, rim) == pytest.approx(dome.point(place, layer, rim), abs=1e-8)
    points = dome.point(place, 0.0)
    rho = np.linspace(0, 0.99 * dome.widest[0], 40)
    assert ellipsoid.inner_point(rho, 0.3) == pytest.approx(dome.inner_point(rho, 0.3), abs=1e-7)
    assert ellipsoid.distance_to_rim(points) == pytest.approx(dome.distance_to_rim(points), abs=1e-4)
    assert ellipsoid.at_arc_length(rho / 2) == pytest.approx(dome.at_arc_length(rho / 2), abs=1e-4)
    assert ellipsoid.radius == pytest.approx(dome.radius)
    assert ellipsoid.widest == pytest.approx(dome.widest, abs=2e-2)
    assert ellipsoid.inner_slope == pytest.approx(dome.inner_slope)
    assert ellipsoid.rim_slope(Rim.FLAT) == pytest.approx(dome.rim_slope(Rim.FLAT))
    assert ellipsoid.bulges == dome.bulges


def test_an_ellipsoid_solves_its_own_equation() -> None:
    skin = Ellipsoid(15.0, 20.0, 2.0, 0.8)
    x, y, z = skin.point(disc(), 0.0).T
    a, c = skin.semi_axis, skin.aspect * skin.semi_axis
    assert (x**2 + y**2) / a**2 + (z - skin.centre_height) ** 2 / c**2 == pytest.approx(1.0)


def test_the_wall_falls_to_the_right_of_its_axis_of_rotation() -> None:
    """By the rotation matrix of the rotation vector (Rodrigues), which `wall_normal` does not use."""
    for rx, ry in ((0.2, 0.0), (0.0, 0.2), (-0.1, 0.15)):
        angle = np.hypot(rx, ry)
        k = np.array([rx, ry, 0.0]) / angle
        cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
        turn = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
        assert wall_normal(rx, ry) == pytest.approx(turn @ [0, 0, 1])
    assert wall_normal(0.1, 0.0)[1] < 0
    assert turn_about_axis(np.pi / 2) @ [1, 0, 0] == pytest.approx([0, 1, 0])


@pytest.mark.parametrize(("height", "base", "aspect"), [(20, 20, 1.3), (30, 15, 0.7), (12, 20, 0.6), (28, 16, 1.6)])
def test_rays_hit_an_ellipsoid_where_its_quadric_says(height: float, base: float, aspect: float) -> None:
    """Scaled along its axis it is a sphere, whose farther crossing has a closed form; some graze.

    The ellipsoid's own answer lies on the ray and solves its equation; what any meridian gives finds the same.
    """
    skin, rng = Ellipsoid(height, base, 2.0, aspect), np.random.default_rng(3)
    origin = np.array([1.0, -0.5, -40.0])
    rays = np.column_stack([rng.uniform(-0.6, 0.6, (400, 2)), np.ones(400)])
    scale, centre = np.array([1.0, 1.0, 1.0 / aspect]), np.array([0.0, 0.0, skin.centre_height])
    start, along = (origin - centre) * scale, rays * scale
    half, square = along @ start, (along**2).sum(axis=1)
    far = (-half + np.sqrt(np.maximum(half**2 - square * (start @ start - skin.semi_axis**2), 0))) / square
    opening = origin + (40.0 / rays[:, 2:]) * rays
    passes = np.hypot(opening[:, 0], opening[:, 1]) <= base
    assert passes.sum() > 100
    for found in (skin.hit(origin, rays), RevolvedSkin.hit(skin, origin, rays)):
        assert found[passes] == pytest.approx((origin + far[:, None] * rays)[passes], abs=1e-9)
        assert np.isnan(found[~passes]).all()
    x, y, z = found[passes].T
    a, c = skin.semi_axis, aspect * skin.semi_axis
    assert (x**2 + y**2) / a**2 + (z - skin.centre_height) ** 2 / c**2 == pytest.approx(1.0, abs=1e-9)
    rho = np.linspace(0.0, 1.01 * skin.widest[0], 200)
    assert skin.inner_point(rho, 0.4) == pytest.approx(
        RevolvedSkin.inner_point(skin, rho, 0.4), abs=1e-9, nan_ok=True
    )
