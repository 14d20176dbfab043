import numpy as np
import pytest

from errors import refused
from palpate.design import Dome, DomeSpec, build_skin
from palpate.design.dome import DomeShape


@pytest.mark.parametrize(
    ("height", "radius", "center_z", "shape"),
    [
        (10.0, 25.0, -15.0, DomeShape.SEGMENT),
        (20.0, 20.0, 0.0, DomeShape.HEMISPHERE),
        (30.0, 65.0 / 3.0, 25.0 / 3.0, DomeShape.CAP),
    ],
)
def test_the_papers_domes_follow_equation_1(height: float, radius: float, center_z: float, shape: DomeShape) -> None:
    dome = build_skin(DomeSpec(height=height, thickness=3))
    assert dome.radius == pytest.approx(radius)
    assert dome.outer_radius == pytest.approx(radius + 3.0)
    assert dome.center_z == pytest.approx(center_z)
    assert dome.shape is shape


@pytest.mark.parametrize("height", [4.0, 10.0, 20.0, 30.0, 55.0])
def test_apex_and_rim_lie_on_the_inner_sphere(height: float) -> None:
    dome = build_skin(DomeSpec(height=height))
    apex, rim = [0.0, 0.0, height], [dome.base_radius, 0.0, 0.0]
    np.testing.assert_allclose(dome.distance([apex, rim]), 0.0, atol=1e-12)
    np.testing.assert_allclose(dome.inner_point(0.0, 0.0), apex, atol=1e-12)
    np.testing.assert_allclose(dome.distance_to_rim(rim), 0.0, atol=1e-12)
    assert dome.distance_to_rim(apex) == pytest.approx(dome.radius * dome.rim_polar_angle)


def test_a_bulging_dome_carries_points_to_its_upper_side() -> None:
    dome = build_skin(DomeSpec(height=30))
    point = dome.inner_point(21.0, np.pi / 2)
    assert point[2] > dome.center_z
    np.testing.assert_allclose(point[:2], [0.0, 21.0], atol=1e-12)


@pytest.mark.parametrize(("height", "rho"), [(10.0, 20.01), (20.0, 20.01), (30.0, 21.7)])
def test_beyond_the_dome_there_is_no_height(height: float, rho: float) -> None:
    assert np.isnan(Dome(height, 20.0, 2.0).inner_point(rho, 0.0)[2])


def test_widest_place_of_a_bulging_dome() -> None:
    assert 2 * Dome(30.0, 20.0, 2.0).widest[0] == pytest.approx(43.3, abs=0.05)
    assert Dome(10.0, 20.0, 2.0).widest[0] == 20.0


@pytest.mark.parametrize(
    ("bad", "code"),
    [
        ({"height": 1.0}, "greater_than_equal"),
        ({"thickness": 0.1}, "greater_than_equal"),
        ({"base_radius": 61.0}, "less_than_equal"),
        ({"hight": 20.0}, "extra_forbidden"),
    ],
)
def test_out_of_bounds_and_unknown_keys_are_refused(bad: dict[str, float], code: str) -> None:
    with refused(code, *bad):
        DomeSpec(**bad)
