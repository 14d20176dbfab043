"""What every skin must satisfy, and the ellipsoid held against the dome by another way."""

import numpy as np
import pytest

from palpate.design import Dome, Ellipsoid, Rim, Skin, rotation_vector, turn_about_axis, wall_normal

SKINS: list[Skin] = [
    Dome(20.0, 20.0, 2.0),
    Dome(10.0, 20.0, 1.0),
    Dome(30.0, 20.0, 3.0),
    Ellipsoid(20.0, 20.0, 2.0, 1.3),
    Ellipsoid(12.0, 20.0, 2.0, 0.7),
    Ellipsoid(28.0, 20.0, 1.0, 1.0),
]
PAIRS = [(Dome(h, 20.0, t), Ellipsoid(h, 20.0, t, 1.0)) for h, t in ((10.0, 1.0), (20.0, 2.0), (30.0, 3.0))]


def disc(count: int = 200, largest: float = 1.0) -> np.ndarray:
    rng = np.random.default_rng(3)
    angle, radius = rng.uniform(0, 2 * np.pi, count), largest * np.sqrt(rng.uniform(0, 1, count))
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


@pytest.mark.parametrize("skin", SKINS, ids=lambda skin: skin.name)
def test_the_disc_is_the_inverse_of_the_inner_surface(skin: Skin) -> None:
    place = disc()
    assert skin.disc(skin.point(place, 0.0)) == pytest.approx(place, abs=1e-9)


@pytest.mark.parametrize("skin", SKINS, ids=lambda skin: skin.name)
def test_apex_rim_and_thickness_are_those_of_the_design(skin: Skin) -> None:
    assert skin.point(np.zeros((1, 2)), 0.0)[0] == pytest.approx([0, 0, skin.height], abs=1e-9)
    assert skin.point(np.array([[0.0, 1.0]]), 0.0)[0] == pytest.approx([0, skin.base_radius, 0], abs=1e-9)
    outer = skin.point(disc(), 1.0, Rim.RADIAL)
    assert skin.distance(outer) == pytest.approx(skin.thickness, abs=1e-8)
    flat = skin.point(np.array([[1.0, 0.0]]), 1.0)[0]
    assert flat[2] == pytest.approx(0.0, abs=1e-8)
    assert flat[0] == pytest.approx(skin.outer_base_radius)


@pytest.mark.parametrize("skin", SKINS, ids=lambda skin: skin.name)
def test_the_normal_is_across_the_surface_and_points_outward(skin: Skin) -> None:
    place, step = disc(largest=0.95), 1e-6
    points, normals = skin.point(place, 0.0), skin.normal(skin.point(place, 0.0))
    for way in np.eye(2):
        slope = (skin.point(place + step * way, 0.0) - skin.point(place - step * way, 0.0)) / (2 * step)
        assert np.abs((slope * normals).sum(axis=1)).max() < 1e-5 * skin.base_radius
    assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0)
    assert (skin.distance(points + 0.1 * normals) > 0).all()
    frame = np.stack(skin.tangents(points), axis=1)
    assert frame @ frame.transpose(0, 2, 1) == pytest.approx(np.broadcast_to(np.eye(3), frame.shape), abs=1e-12)


@pytest.mark.parametrize("skin", SKINS, ids=lambda skin: skin.name)
def test_points_off_the_surface_are_put_back_along_its_normal(skin: Skin) -> None:
    points = skin.point(disc(largest=0.9), 0.0)
    normals = skin.normal(points)
    for offset in (-1.5, 0.7):
        assert skin.nearest(points + offset * normals) == pytest.approx(points, abs=1e-8)
        assert skin.distance(points + offset * normals) == pytest.approx(offset, abs=1e-9)


@pytest.mark.parametrize("skin", SKINS, ids=lambda skin: skin.name)
def test_rays_from_below_hit_the_surface_that_they_were_drawn_to(skin: Skin) -> None:
    points = skin.point(disc(largest=0.6), 0.0)
    origin = np.array([1.0, -0.5, -40.0])
    assert skin.hit(origin, points - origin) == pytest.approx(points, abs=1e-7)
    assert np.isnan(skin.hit(origin, np.array([[1.0, 0.0, 0.0]]))).all()


@pytest.mark.parametrize("skin", SKINS, ids=lambda skin: skin.name)
def test_no_point_of_the_outer_surface_is_beyond_the_wall_at_first_touch(skin: Skin) -> None:
    outer = skin.point(disc(4000, 1.0), 1.0)
    for tilt in (0.0, 5.0, 12.0):
        normal = wall_normal(*rotation_vector(np.radians(tilt), 0.4))
        touched = skin.touch(normal)
        height = (outer - touched) @ normal
        assert height.max() < 1e-9
        assert height.max() > -0.02 * skin.base_radius
        assert skin.distance(touched) == pytest.approx(skin.thickness, abs=1e-9)


@pytest.mark.parametrize("skin", SKINS, ids=lambda skin: skin.name)
def test_the_clamp_is_reached_where_the_wall_passes_the_outer_rim(skin: Skin) -> None:
    tilt = np.radians(4.0)
    normal = wall_normal(tilt, 0.0)
    edge = np.array([0.0, -skin.outer_base_radius, 0.0])
    way = (skin.touch(normal) - edge) @ normal / normal[2]
    assert skin.clamp_depth(tilt, Rim.FLAT) == pytest.approx(way, rel=1e-9)


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


@pytest.mark.parametrize("skin", SKINS, ids=lambda skin: skin.name)
def test_a_scaled_skin_is_the_same_shape(skin: Skin) -> None:
    place = disc()
    assert skin.scaled(2.5).point(place, 0.7) == pytest.approx(2.5 * skin.point(place, 0.7), rel=1e-7, abs=1e-7)


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
