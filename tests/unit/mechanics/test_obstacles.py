"""Gap functions: the gradient is the normal, the Hessian its slope; a ball and a bar of large radius are a plane."""

import numpy as np
import pytest

from palpate.fea import Ball, Cylinder, Plane
from palpate.mechanics import Obstacle

TILTED = np.array([0.3, -0.2, np.sqrt(1 - 0.13)])
OBSTACLES: dict[str, Obstacle] = {
    "plane": Plane(TILTED, np.array([1.0, 2.0, 3.0])),
    "ball": Ball(5.0, np.array([1.0, -1.0, 6.0])),
    "cylinder": Cylinder(4.0, np.array([0.0, 1.0, 5.0]), np.array([0.6, 0.8, 0.0])),
}
POINTS = np.random.default_rng(0).uniform(-3, 3, (50, 3))


@pytest.mark.parametrize("obstacle", OBSTACLES.values(), ids=OBSTACLES)
def test_normal_and_curvature_are_the_slopes_of_the_reach(obstacle: Obstacle) -> None:
    gap, step = obstacle.gap(POINTS), 1e-5
    curvature = np.zeros((len(POINTS), 3, 3)) if gap.curvature is None else gap.curvature
    for axis in range(3):
        ahead, behind = POINTS + step * np.eye(3)[axis], POINTS - step * np.eye(3)[axis]
        slope = (obstacle.reach(ahead) - obstacle.reach(behind)) / (2 * step)
        assert gap.normal[:, axis] == pytest.approx(slope, abs=1e-8)
        bend = (obstacle.gap(ahead).normal - obstacle.gap(behind).normal) / (2 * step)
        assert curvature[:, :, axis] == pytest.approx(bend, abs=1e-8)
    assert gap.reach == pytest.approx(obstacle.reach(POINTS))
    assert np.linalg.norm(gap.normal, axis=1) == pytest.approx(1.0)


@pytest.mark.parametrize("obstacle", OBSTACLES.values(), ids=OBSTACLES)
def test_a_foot_lies_on_the_surface_and_moves_with_the_obstacle(obstacle: Obstacle) -> None:
    reach, place = obstacle.foot(POINTS)
    assert obstacle.reach(obstacle.point + place) == pytest.approx(0.0, abs=1e-9)
    assert np.linalg.norm(POINTS - obstacle.point - place, axis=1) == pytest.approx(np.abs(reach))
    by = np.array([0.3, -0.1, 0.5])
    again, same = obstacle.moved(by).foot(POINTS + by)
    assert again == pytest.approx(reach)
    assert same == pytest.approx(place)


@pytest.mark.parametrize("obstacle", OBSTACLES.values(), ids=OBSTACLES)
def test_a_patch_lies_on_the_surface_and_is_counter_clockwise_from_inside(obstacle: Obstacle) -> None:
    at = obstacle.point + obstacle.foot(POINTS[:1])[1][0]
    points, quads = obstacle.patch(at, 3.0)
    assert np.abs(obstacle.reach(points)).max() < 1e-9
    a, b, c, d = points[quads].transpose(1, 0, 2)
    facing = np.cross(c - a, d - b)
    assert ((facing * obstacle.gap((a + b + c + d) / 4).normal).sum(axis=1) > 0).all()


def test_a_huge_ball_and_a_huge_bar_are_a_plane() -> None:
    radius = 1e7
    middle = np.array([0.0, 0.0, 1.0 + radius])
    flat = Plane(np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0]))
    for obstacle in (Ball(radius, middle), Cylinder(radius, middle, np.array([1.0, 0.0, 0.0]))):
        assert obstacle.reach(POINTS) == pytest.approx(flat.reach(POINTS), abs=1e-5)
