"""Flat pads and the superellipse of their plan."""

import numpy as np
import pytest
from scipy.special import gamma

from errors import refused
from palpate.design import ConeSpec, Symmetry, read_skin, rotation_vector, wall_normal
from palpate.design.flat_pad import FlatPadSpec
from palpate.design.superellipse import Superellipse

SIZES = {"height": 3.5, "base_radius": 10.4, "thickness": 0.5}
PAD = FlatPadSpec(**SIZES, stretch=1.2, squareness=6.0).build()
ANGLES = np.linspace(0, 2 * np.pi, 3601)


@pytest.mark.parametrize("exponent", [2.0, 4.0, 6.0, 10.0])
def test_a_plan_is_what_its_formulas_say(exponent: float) -> None:
    plan, step = Superellipse(1.3, exponent), 1e-5
    edge, turn, bend = plan.edge(ANGLES)
    assert plan.pseudo_radius(edge) == pytest.approx(1.0)
    area = 0.5 * np.trapezoid(edge[:, 0] * turn[:, 1] - edge[:, 1] * turn[:, 0], ANGLES)
    assert area == pytest.approx(4 * 1.3 * gamma(1 + 1 / exponent) ** 2 / gamma(1 + 2 / exponent), rel=1e-9)
    after, before = plan.edge(ANGLES + step), plan.edge(ANGLES - step)
    assert turn == pytest.approx((after[0] - before[0]) / (2 * step), abs=1e-6)
    assert bend == pytest.approx((after[1] - before[1]) / (2 * step), abs=1e-4)
    assert (plan.gradient(edge) * turn).sum(axis=1) == pytest.approx(0.0, abs=1e-9)
    assert np.linalg.norm(edge, axis=1).max() == pytest.approx(plan.farthest, rel=1e-5)


@pytest.mark.parametrize("exponent", [2.0, 6.0])
def test_no_point_of_a_plan_is_farther_along_a_way_than_its_support(exponent: float) -> None:
    plan = Superellipse(1.3, exponent)
    edge = plan.edge(ANGLES)[0]
    for way in (np.array([1.0, 0.0]), np.array([0.0, -1.0]), np.array([0.5, 0.2]), np.array([1e-3, 1.0])):
        assert (edge @ way).max() == pytest.approx(plan.support(way), rel=1e-5)
        assert plan.support_point(way) @ way == pytest.approx(plan.support(way))


def test_a_pad_with_a_round_plan_is_the_cone() -> None:
    pad = FlatPadSpec(**SIZES, stretch=1.0, squareness=2.0).build()
    cone = ConeSpec(**SIZES, flat_radius=8.0, edge_radius=2.0).build()
    rng = np.random.default_rng(0)
    disc = rng.uniform(-0.6, 0.6, (100, 2))
    for layer in (0.0, 0.5, 1.0):
        assert pad.point(disc, layer) == pytest.approx(cone.point(disc, layer))
    points = cone.point(disc, 0.0) + rng.uniform(-0.1, 0.1, (100, 3))
    assert pad.distance(points) == pytest.approx(cone.distance(points), abs=1e-9)
    assert pad.normal(points) == pytest.approx(cone.normal(points), abs=1e-7)
    normal = wall_normal(*rotation_vector(np.radians(2), 0.7))
    assert pad.support_point(normal) == pytest.approx(cone.support_point(normal))
    assert pad.clamp_depth(0.1, "flat") == pytest.approx(cone.clamp_depth(0.1, "flat"))
    assert pad.rim_slope("flat") == pytest.approx(cone.rim_slope("flat"))
    assert pad.widest == pytest.approx(cone.widest)


def test_the_top_is_flat_and_the_sides_are_those_of_the_design() -> None:
    disc = 0.6 * np.column_stack([np.cos(ANGLES), np.sin(ANGLES)])
    assert PAD.point(disc, 0.0)[:, 2] == pytest.approx(3.5)
    assert PAD.point(disc, 1.0)[:, 2] == pytest.approx(4.0)
    rim = PAD.point(disc / 0.6, 0.0)
    assert np.abs(rim).max(axis=0)[:2] == pytest.approx([10.4, 1.2 * 10.4])
    assert PAD.symmetry is Symmetry.MIRRORED


def test_nearest_points_are_found_where_the_plan_has_no_curvature() -> None:
    ways = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 1e-4], [0.7, 0.72]])
    roots = np.concatenate([PAD.point(s * ways / np.linalg.norm(ways, axis=1)[:, None], 0.0) for s in (0.8, 0.9)])
    normals = PAD.normal(roots)
    for offset in (-0.3, 0.4):
        assert PAD.nearest(roots + offset * normals) == pytest.approx(roots, abs=1e-8)


def test_rays_from_under_the_window_meet_every_side() -> None:
    disc = 0.9 * np.column_stack([np.cos(ANGLES[::100]), np.sin(ANGLES[::100])])
    points = PAD.point(disc, 0.0)
    origin = np.array([0.0, 0.0, -24.0])
    assert PAD.hit(origin, points - origin) == pytest.approx(points, abs=1e-7)


def test_walls_of_every_azimuth_first_touch_the_outer_surface_where_nothing_is_above_them() -> None:
    outer = PAD.point(np.random.default_rng(1).uniform(-0.7, 0.7, (4000, 2)), 1.0)
    for azimuth in np.radians([0, 1, 30, 45, 90, 200]):
        normal = wall_normal(*rotation_vector(np.radians(3), azimuth))
        assert ((outer - PAD.support_point(normal)) @ normal).max() < 1e-9
        assert PAD.support_height(normal[None])[0] == pytest.approx(
            PAD.support_point(normal) @ normal / normal[2], abs=1e-9
        )


def test_a_pad_that_hangs_over_its_window_is_refused() -> None:
    with refused("pad-overhangs", "8"):
        FlatPadSpec(height=6, base_radius=8, flat_radius=7.5, edge_radius=2).build()


def test_a_pad_is_read_from_words() -> None:
    assert read_skin("pad:squareness=4", FlatPadSpec(**SIZES)).build().squareness == 4
