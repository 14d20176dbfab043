"""Contract suite of obstacles."""

from __future__ import annotations

import numpy as np
import pytest

from palpate.core import FloatArray
from palpate.fea import OBSTACLES, ObstacleSpec, obstacle_from_data
from palpate.mechanics import Obstacle
from palpate.mesh import Mesh


class ObstacleSuite:
    """Inherit and give the fixtures `spec`, `mesh` and `points`; pytest collects the rest."""

    @pytest.fixture
    def spec(self) -> ObstacleSpec:
        """An obstacle off the axis, at a place without symmetry."""
        raise NotImplementedError("Give the fixture `spec`.")

    @pytest.fixture
    def mesh(self) -> Mesh:
        """A mesh that it is brought down on."""
        raise NotImplementedError("Give the fixture `mesh`.")

    @pytest.fixture
    def contact(self, spec: ObstacleSpec, mesh: Mesh) -> tuple[Obstacle, FloatArray]:
        """The obstacle at first contact, and the place (3,) mm that it touches first."""
        return spec.at_first_contact(mesh)

    @pytest.fixture
    def obstacle(self, contact: tuple[Obstacle, FloatArray]) -> Obstacle:
        """The obstacle at first contact."""
        return contact[0]

    @pytest.fixture
    def points(self, contact: tuple[Obstacle, FloatArray]) -> FloatArray:
        """Points (n, 3) mm about the place that it touches first."""
        touched = contact[1]
        return touched + np.random.default_rng(0).uniform(-0.5, 0.5, (60, 3))

    def test_it_is_read_again_from_its_data(self, spec: ObstacleSpec) -> None:
        assert obstacle_from_data(spec.model_dump(mode="json")) == spec
        assert type(spec) in [OBSTACLES.get(name) for name in OBSTACLES.names]

    def test_normal_and_curvature_are_the_slopes_of_the_reach(self, obstacle: Obstacle, points: FloatArray) -> None:
        gap, step = obstacle.gap(points), 1e-5
        curvature = np.zeros((len(points), 3, 3)) if gap.curvature is None else gap.curvature
        for axis in range(3):
            ahead, behind = points + step * np.eye(3)[axis], points - step * np.eye(3)[axis]
            slope = (obstacle.penetration(ahead) - obstacle.penetration(behind)) / (2 * step)
            assert gap.normal[:, axis] == pytest.approx(slope, abs=1e-7)
            bend = (obstacle.gap(ahead).normal - obstacle.gap(behind).normal) / (2 * step)
            assert curvature[:, :, axis] == pytest.approx(bend, abs=1e-7)
        assert gap.penetration == pytest.approx(obstacle.penetration(points))
        assert np.linalg.norm(gap.normal, axis=1) == pytest.approx(1.0)

    def test_a_foot_lies_on_the_surface_and_moves_with_the_obstacle(
        self, obstacle: Obstacle, points: FloatArray
    ) -> None:
        reach, place = obstacle.closest_points(points)
        assert obstacle.penetration(obstacle.point + place) == pytest.approx(0.0, abs=1e-6)
        by = np.array([0.3, -0.1, 0.5])
        again, same = obstacle.moved(by).closest_points(points + by)
        assert again == pytest.approx(reach)
        assert same == pytest.approx(place)

    def test_at_first_touch_it_touches_the_skin_and_enters_it_nowhere(self, spec: ObstacleSpec, mesh: Mesh) -> None:
        obstacle, touched = spec.at_first_contact(mesh)
        length = mesh.skin.base_radius
        assert obstacle.penetration(touched[None])[0] == pytest.approx(0.0, abs=1e-7 * length)
        angle, radius = np.meshgrid(np.linspace(-np.pi / 2, np.pi / 2, 91), np.linspace(0, 1, 60))
        disc = np.column_stack([(radius * np.cos(angle)).ravel(), (radius * np.sin(angle)).ravel()])
        outside = mesh.skin.point(disc, 1.0, mesh.spec.rim)
        assert obstacle.penetration(outside).max() < 1e-6 * length
        assert obstacle.penetration(outside).max() > -0.02 * length

    def test_its_patch_lies_on_it_and_is_counter_clockwise_from_inside(self, spec: ObstacleSpec, mesh: Mesh) -> None:
        obstacle, touched = spec.at_first_contact(mesh)
        points, quads = obstacle.patch(touched, 0.1 * mesh.skin.base_radius)
        assert np.abs(obstacle.penetration(points)).max() < 1e-6 * mesh.skin.base_radius
        a, b, c, d = points[quads].transpose(1, 0, 2)
        facing = np.cross(c - a, d - b)
        assert ((facing * obstacle.gap((a + b + c + d) / 4).normal).sum(axis=1) > 0).all()
