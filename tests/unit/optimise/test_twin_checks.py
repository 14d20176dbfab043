"""The presses that tell what a twin is off are none of its own."""

import numpy as np
import pytest

from palpate.calibration import ToleranceSpec
from palpate.design import DomeSpec
from palpate.optimise import RequirementsSpec
from palpate.optimise.evaluate_skin import plan_skin_evaluation

SPEC = RequirementsSpec(name="small", depth=4.0)
TASK = plan_skin_evaluation(SPEC, DomeSpec(height=20, thickness=2), SPEC.materials[0], full=True)
PRESSES = [press for checks in TASK.checks for press in checks.presses]


def test_checks_lie_between_the_presses_of_a_twin_and_on_another_mesh() -> None:
    own = [press.obstacle for press in TASK.twin.presses]
    for press in PRESSES:
        assert press.obstacle.radial not in {wall.radial for wall in own}
        assert press.obstacle.contact not in {wall.contact for wall in own}
        assert press.obstacle.radial < max(wall.radial for wall in own)
        assert press.mesh.cells > 20
        assert press.solver.derivatives == ()


def test_their_frictions_have_mean_and_variance_of_those_that_are_met() -> None:
    frictions = sorted({press.obstacle.contact for press in PRESSES})
    met = SPEC.tolerance.friction_min * np.linspace(1.0, 2.0, 10_001)
    assert len(frictions) == 2
    assert np.mean(frictions) == pytest.approx(met.mean(), abs=1e-3)
    assert np.var(frictions) == pytest.approx(met.var(), rel=1e-2)


def test_walls_without_friction_are_checked_once() -> None:
    smooth = SPEC.model_copy(update={"tolerance": ToleranceSpec(friction_min=0.0)})
    checks = plan_skin_evaluation(smooth, DomeSpec(height=20, thickness=2), SPEC.materials[0], full=True).checks
    assert [len(each.presses) for each in checks] == [5]
    assert {press.obstacle.contact for press in checks[0].presses} == {TASK.twin.presses[0].obstacle.contact}


def test_tilts_that_are_read_have_mean_and_variance_of_those_that_are_met() -> None:
    tilts, met = [press.obstacle.radial for press in TASK.checks[0].read], np.linspace(0.0, SPEC.max_tilt_deg, 10_001)
    weights = np.array([5.0, 8.0, 5.0]) / 18.0
    mean = weights @ tilts
    assert mean == pytest.approx(met.mean(), rel=0.05)
    assert weights @ (np.array(tilts) - mean) ** 2 == pytest.approx(met.var(), rel=0.1)
