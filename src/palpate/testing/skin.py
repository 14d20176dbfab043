"""Contract suite of skins."""

from __future__ import annotations

import numpy as np
import pytest

from palpate.core import FloatArray
from palpate.design import Rim, Skin, Symmetry, rotation_vector, skin_from_data, wall_normal

_COUNT = 200
"""Number of random points on a skin."""


class SkinSuite:
    """Inherit and give the fixture `skin`; pytest collects the rest."""

    @pytest.fixture
    def skin(self) -> Skin:
        """A skin of usual proportions."""
        raise NotImplementedError("Give the fixture `skin`.")

    @pytest.fixture
    def disc(self) -> FloatArray:
        """Places (n, 2) on the unit disc, away from its edge."""
        rng = np.random.default_rng(3)
        angle, radius = rng.uniform(0, 2 * np.pi, _COUNT), 0.95 * np.sqrt(rng.uniform(0, 1, _COUNT))
        return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])

    def test_it_is_read_again_from_its_data(self, skin: Skin, disc: FloatArray) -> None:
        again = skin_from_data(skin.spec_data).build()
        assert again.point(disc, 0.5) == pytest.approx(skin.point(disc, 0.5))
        assert again.name == skin.name

    def test_the_disc_is_the_inverse_of_the_marked_surface(self, skin: Skin, disc: FloatArray) -> None:
        assert skin.disc(skin.marked(disc)) == pytest.approx(disc, abs=1e-8)
        assert skin.point(disc, 0.0) == pytest.approx(skin.marked(disc) + skin.pin * skin.normal(skin.marked(disc)))

    def test_apex_rim_and_thickness_are_those_of_the_design(self, skin: Skin, disc: FloatArray) -> None:
        assert skin.point(np.zeros((1, 2)), 0.0)[0] == pytest.approx([0, 0, skin.height], abs=1e-8)
        assert skin.point(np.array([[1.0, 0.0]]), 0.0)[0] == pytest.approx([skin.base_radius, 0, 0], abs=1e-8)
        wall = skin.distance(skin.point(disc, 1.0, Rim.RADIAL)) - skin.pin
        ends = (skin.thickness, skin.rim_thickness)
        assert min(ends) - 1e-7 < wall.min() <= wall.max() < max(ends) + 1e-7
        edge = skin.point(np.array([[1.0, 0.0]]), 1.0)[0]
        assert edge[2] == pytest.approx(0.0, abs=1e-7)
        assert edge[0] == pytest.approx(skin.outer_base_radius)

    def test_the_normal_is_across_the_surface_and_points_outward(self, skin: Skin, disc: FloatArray) -> None:
        points, step = skin.marked(disc), 1e-6
        normals = skin.normal(points)
        for way in np.eye(2):
            slope = (skin.marked(disc + step * way) - skin.marked(disc - step * way)) / (2 * step)
            assert np.abs((slope * normals).sum(axis=1)).max() < 1e-5 * skin.base_radius
        assert np.linalg.norm(normals, axis=1) == pytest.approx(1.0)
        frame = np.stack(skin.tangents(points), axis=1)
        assert frame @ frame.transpose(0, 2, 1) == pytest.approx(np.broadcast_to(np.eye(3), frame.shape), abs=1e-9)

    def test_points_near_the_surface_are_put_back_along_its_normal(self, skin: Skin, disc: FloatArray) -> None:
        points = skin.marked(0.9 * disc)
        normals = skin.normal(points)
        for offset in (-0.05 * skin.radius, 0.3 * skin.thickness):
            assert skin.nearest(points + offset * normals) == pytest.approx(points, abs=1e-7)
            assert skin.distance(points + offset * normals) == pytest.approx(offset, abs=1e-8)

    def test_points_are_carried_up_to_the_surface_and_outside_it_nowhere(self, skin: Skin) -> None:
        rho = np.linspace(0, 0.98 * float(skin.reach(0.3)), 40)
        points = skin.inner_point(rho, 0.3)
        assert skin.distance(points) == pytest.approx(0.0, abs=1e-7)
        assert np.hypot(points[:, 0], points[:, 1]) == pytest.approx(rho)
        azimuth = np.linspace(0, 2 * np.pi, 60, endpoint=False)
        assert np.isnan(skin.inner_point(1.01 * skin.reach(azimuth), azimuth)[:, 2]).all()
        assert skin.reach(np.linspace(0, np.pi, 721)).max() == pytest.approx(skin.widest[0], rel=1e-4)

    def test_lengths_along_the_meridian_add_up(self, skin: Skin, disc: FloatArray) -> None:
        whole, half = (
            skin.arc_length(points) + skin.distance_to_rim(points)
            for points in (skin.marked(disc), skin.marked(0.5 * disc))
        )
        assert whole == pytest.approx(half, rel=1e-6)
        if skin.symmetry is Symmetry.REVOLVED:
            assert whole == pytest.approx(whole[0], rel=1e-6)
        points = skin.marked(np.column_stack([np.hypot(*disc.T), np.zeros(len(disc))]))
        near = points[points[:, 0] < 0.9 * float(skin.reach(0.0))]
        near = near[near[:, 2] > skin.widest[1]]
        assert skin.at_arc_length(skin.arc_length(near)) == pytest.approx(near[:, 0], abs=1e-3)

    def test_rays_from_below_hit_the_surface_that_they_were_drawn_to(self, skin: Skin, disc: FloatArray) -> None:
        points = skin.marked(0.6 * disc)
        origin = np.array([0.05, -0.02, -2.0]) * skin.base_radius
        assert skin.hit(origin, points - origin) == pytest.approx(points, abs=1e-6)
        assert np.isnan(skin.hit(origin, np.array([[1.0, 0.0, 0.0]]))).all()
        rays = points - origin
        own = origin - (origin[2] / rays[:, 2:]) * rays
        assert skin.hit(own, rays) == pytest.approx(points, abs=1e-6)

    def test_no_point_of_the_outer_surface_is_beyond_the_wall_at_first_touch(
        self, skin: Skin, disc: FloatArray
    ) -> None:
        outer = skin.point(disc, 1.0)
        for tilt in (0.0, 5.0, 12.0):
            normal = wall_normal(*rotation_vector(np.radians(tilt), 0.4))
            height = (outer - skin.support_point(normal)) @ normal
            assert height.max() < 1e-7 * skin.base_radius
            wall, ends = skin.distance(skin.support_point(normal)) - skin.pin, (skin.thickness, skin.rim_thickness)
            assert min(ends) - 1e-7 < wall < max(ends) + 1e-7
            assert height.max() > -0.02 * skin.base_radius

    def test_the_clamp_is_reached_where_the_wall_passes_the_outer_rim(self, skin: Skin) -> None:
        tilt, azimuth = np.radians(4.0), np.linspace(0, 2 * np.pi, 720, endpoint=False)
        edge = skin.point(np.column_stack([np.cos(azimuth), np.sin(azimuth)]), 1.0)
        normals = [wall_normal(*rotation_vector(tilt, turn)) for turn in azimuth[::15]]
        way = min(float(((skin.support_point(normal) - edge) @ normal).min()) for normal in normals) / np.cos(tilt)
        assert skin.clamp_depth(tilt, Rim.FLAT) == pytest.approx(
            way, rel=1e-7 if skin.symmetry is Symmetry.REVOLVED else 1e-3
        )
        assert skin.clamp_depth(tilt, Rim.FLAT) <= way * (1 + 1e-7)

    def test_a_scaled_skin_is_the_same_shape(self, skin: Skin, disc: FloatArray) -> None:
        assert skin.scaled(2.5).point(disc, 0.7) == pytest.approx(2.5 * skin.point(disc, 0.7), rel=1e-6, abs=1e-6)
