"""The axisymmetric triangles, by Hertz's law and by figures of another axisymmetric program."""

import numpy as np
import pytest

from palpate.verify.read_reference import read_reference
from validation import REFERENCE
from validation.half_sphere import press_half_ball

C10 = 0.0141156


def hertz(depth: float) -> float:
    """Force (N) on a half ball of radius 1 mm; Johnson 1985, section 4.2, with E* = 4/3 · 6 C10."""
    return 4 / 3 * 8 * C10 * depth**1.5


@pytest.mark.parametrize("bonded", [True, False])
def test_lightly_pressed_it_is_hertz(bonded: bool) -> None:
    """The ratio to Hertz's force grows with a/R; carried to 0 it is 1."""
    depths = [0.001, 0.002, 0.004]
    found = press_half_ball(depths, C10, bonded=bonded, cell=0.005)
    ratio = np.array([item.force for item in found]) / [hertz(depth) for depth in depths]
    assert ratio == pytest.approx(1.0, abs=0.045)
    _, limit = np.polyfit(np.sqrt(depths), ratio, 1)
    assert limit == pytest.approx(1.0, abs=0.01)


def test_sliding_on_its_base_it_is_half_of_a_ball_between_plates() -> None:
    data = (
        read_reference("sphere_compression", REFERENCE)
        .where(material="neo", mesh_n="20")
        .between("delta_over_R", 0.05, 0.2)
    )
    found = press_half_ball(list(data["delta_over_R"]), C10, bonded=False, cell=0.05)
    assert [100 * item.force for item in found] == pytest.approx(data["force_N"], rel=6e-3)
    assert [1000 * item.energy for item in found] == pytest.approx(data["strain_energy_mJ_half"], rel=6e-3)


def test_bonded_it_is_stiffer_and_its_axis_sinks_less_towards_the_base() -> None:
    bonded, sliding = (
        press_half_ball([0.1], C10, [0.0, 0.5, 1.0], bonded=way, cell=0.05)[0] for way in (True, False)
    )
    assert bonded.force > 1.08 * sliding.force
    assert bonded.sunk[0] == pytest.approx(0.0, abs=1e-12)
    assert 0 < bonded.sunk[1] < sliding.sunk[1]
    assert bonded.sunk[2] == pytest.approx(0.1, rel=2e-3)
