"""The proof: how far what was played is from what was foreseen, and in which order."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from errors import check_values
from palpate.calibration import PredictedAccuracy
from palpate.core.report import page_markdown
from palpate.optimise import SimulatedAccuracy, SolverComparison, ValidatedDesign, ValidationResult
from palpate.optimise.validation import validation_page

FIGURES = ((0.020, 0.080), (0.0203, 0.0808)), ((0.021, 0.083), (0.0201, 0.0800))
"""Foreseen and played of two designs."""


def design(
    title: str, foreseen: tuple[float, float], played: tuple[float, float], shares: Sequence[float] = (1.0,) * 20
) -> ValidatedDesign:
    """A design whose units have these shares of both figures that were played."""
    told, units = PredictedAccuracy(5, *foreseen, depth_rmse=0.01, noise_deg=0.01), tuple(shares)
    by_unit = tuple((share * played[0], share * played[1]) for share in units)
    found = SimulatedAccuracy(len(units), 2160, 0, *played, depth_rmse=0.01, by_unit=by_unit)
    return ValidatedDesign(title, "H20 T2", 91, 48.0, 0.6, told, found)


def test_the_figure_that_is_farthest_off_counts() -> None:
    assert design("winner", (0.02, 0.08), (0.021, 0.1)).relative_error == pytest.approx(0.25)


def test_the_order_is_the_same_only_where_both_figures_say_so() -> None:
    winner, rival = design("winner", (0.02, 0.08), (0.021, 0.09)), design("rival", (0.026, 0.1), (0.027, 0.11))
    outlier = design("winner", (0.02, 0.08), (0.021, 0.15))
    assert ValidationResult((winner, rival), calibration_presses=5).order_preserved
    assert not ValidationResult((outlier, rival), calibration_presses=5).order_preserved
    same, other = (
        list(validation_page(ValidationResult((one, rival), calibration_presses=5))) for one in (winner, outlier)
    )
    check_values(same[-1], "12 %")
    check_values(other[-1], "88 %", "winner and rival")
    assert "winner and rival" not in same[-1]


def test_an_order_that_other_units_would_turn_is_not_contradicted() -> None:
    """Two designs one per cent apart, read by units that are not alike, and by units that all say the same."""
    rng = np.random.default_rng(1)
    better = design("winner", (0.020, 0.080), (0.0203, 0.0808), rng.uniform(0.7, 1.3, 20))
    worse = design("rival", (0.021, 0.083), (0.0201, 0.0800), rng.uniform(0.7, 1.3, 20))
    proof = ValidationResult((better, worse), calibration_presses=5)
    assert not proof.order_preserved
    assert proof.reversed_pairs == ()
    alike = rng.uniform(0.7, 1.3, 20)
    sure = ValidationResult(
        (design("winner", *FIGURES[0], alike), design("rival", *FIGURES[1], alike)), calibration_presses=5
    )
    assert sure.reversed_pairs == ("winner and rival",)
    check_values(page_markdown(validation_page(sure)), "winner and rival")


def test_spans_are_those_of_the_normal_distribution_where_units_are_many() -> None:
    """The mean square of n numbers has a standard deviation of that of a square over the root of n."""
    shares = np.abs(np.random.default_rng(2).standard_normal(600))
    spans = design("winner", (0.02, 0.08), (0.02, 0.08), shares).simulated.bootstrap_intervals
    squares = (0.02 * shares) ** 2
    half = 1.645 * squares.std() / np.sqrt(len(shares)) / (2.0 * np.sqrt(squares.mean()))
    assert spans[0].mean() == pytest.approx(np.sqrt(squares.mean()), rel=0.01)
    assert np.diff(spans[0])[0] == pytest.approx(2.0 * half, rel=0.1)


def test_units_that_gave_no_pose_are_left_out_of_both() -> None:
    units = ((0.02, 0.08), None, (0.03, 0.09))
    found = SimulatedAccuracy(2, 216, 0, 0.0255, 0.09, 0.01, ("unit 2: dark",), units)
    one = replace(design("winner", (0.02, 0.08), (0.0255, 0.09)), simulated=found)
    other = design("rival", (0.03, 0.1), (0.02, 0.08), (1.0, 50.0, 1.0))
    assert found.bootstrap_intervals[0] == pytest.approx([0.02, 0.03])
    assert ValidationResult((one, other), calibration_presses=5).reversed_pairs == ()
    apart = replace(found, by_unit=(None, (0.02, 0.08), None)), replace(found, by_unit=((0.02, 0.08), None, None))
    assert (
        ValidationResult(tuple(replace(one, simulated=each) for each in apart), calibration_presses=5).reversed_pairs
        == ()
    )


def test_a_page_says_from_which_depth_the_solvers_part() -> None:
    second = SolverComparison(4.8, 0.177, 0.182, 0.043, branches_differ_from_mm=5.6)
    page = page_markdown(
        validation_page(ValidationResult((design("winner", (0.02, 0.08), (0.02, 0.08)),), 5, second))
    )
    check_values(page, "5.6 mm", "+2.8 %")
