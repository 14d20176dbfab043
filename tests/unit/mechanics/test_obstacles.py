"""A ball and a bar of large radius are a plane."""

import numpy as np
import pytest

from palpate.fea import Ball, Cylinder, Plane

POINTS = np.random.default_rng(0).uniform(-3, 3, (50, 3))


def test_a_huge_ball_and_a_huge_bar_are_a_plane() -> None:
    radius = 1e7
    middle = np.array([0.0, 0.0, 1.0 + radius])
    flat = Plane(np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, 1.0]))
    for obstacle in (Ball(radius, middle), Cylinder(radius, middle, np.array([1.0, 0.0, 0.0]))):
        assert obstacle.penetration(POINTS) == pytest.approx(flat.penetration(POINTS), abs=1e-5)
