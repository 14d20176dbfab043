"""Laws of rings against closed forms: waves that are turned, and the rim of a sphere."""

import numpy as np
import pytest

from palpate.vision.find_rings_by_structure import turned
from palpate.vision.ring_model import _RIM, Profile
from palpate.vision.rings import ring_harmonics


def test_a_turned_ring_has_the_same_points_at_turned_azimuths() -> None:
    weights, azimuth = np.random.default_rng(1).normal(size=(7, 2)), np.linspace(0.0, 6.0, 25)
    points = ring_harmonics(azimuth + 0.7, 7) @ weights
    assert ring_harmonics(azimuth, 7) @ turned(weights, 0.7) == pytest.approx(points, abs=1e-12)


@pytest.mark.parametrize("centre", [-8.0, 0.0, 5.0])
def test_rings_of_a_sphere_are_followed_to_its_equator(centre: float) -> None:
    rho = np.array([2.0, 5.0, 8.0, 11.0])
    height = centre + np.sqrt(20.0**2 - rho**2)
    law = Profile(rho, height, 100.0 * rho / (60.0 - height))
    assert law.widest == pytest.approx(_RIM * 20.0, rel=1e-9)
