"""Controls: what is wrong by a few percent, or pressed otherwise, does not pass for the published."""

from collections.abc import Callable
from functools import partial

import pytest

from palpate.verify.case import Row
from validation.blocks import bonded_disc
from validation.caps import loaded_cap
from validation.everted import bistable_cap
from validation.filled import filled_hemisphere
from validation.pads import pressed_pad
from validation.roofs import hinged_roof
from validation.spheres import complete_spheres, sphere_point
from validation.tubes import pulled_cylinder

SLOW = [pytest.mark.slow(30)]


@pytest.mark.parametrize(
    ("control", "failing"),
    [
        pytest.param(partial(loaded_cap, "ring", 1.05), 1, id="cap 5 % thicker"),
        pytest.param(partial(hinged_roof, 12.7, 1.03), 3, id="thick roof 3 % thicker"),
        pytest.param(partial(hinged_roof, 6.35, 1.03), 1, id="thin roof 3 % thicker", marks=SLOW),
        pytest.param(partial(sphere_point, 1.05), 2, id="sphere under a force 5 % thicker"),
        pytest.param(partial(bonded_disc, bonded=False), 2, id="slippery discs"),
        pytest.param(partial(pressed_pad, "ball", 1.05), 1, id="pad under a ball 5 % thicker", marks=SLOW),
        pytest.param(partial(pressed_pad, "bar", 1.05), 1, id="pad under a bar 5 % thicker"),
        pytest.param(partial(filled_hemisphere, bonded=False), 2, id="half ball sliding on its base", marks=SLOW),
        pytest.param(partial(pulled_cylinder, 1.03), 3, id="cylinder 3 % thicker", marks=SLOW),
        pytest.param(partial(bistable_cap, 1.05), 2, id="bistable caps 5 % thicker", marks=SLOW),
        pytest.param(
            partial(complete_spheres, (20.0, 40.0), 1.05), 2, id="sphere under pressure 5 % thicker", marks=SLOW
        ),
    ],
)
def test_a_control_does_not_pass(control: Callable[[], list[Row]], failing: int) -> None:
    assert sum(not row.passed for row in control()) >= failing
