import numpy as np
import pytest

from palpate.verify.case import below, compare


def test_a_row_keeps_the_value_that_deviates_most() -> None:
    row = compare("force, N", [1.0, 2.2, 3.0], [1.0, 2.0, 3.1], 0.05, ["a", "b", "c"])
    assert (row.at, row.ours, row.reference, row.count) == ("b", 2.2, 2.0, 3)
    assert row.deviation == pytest.approx(0.1)
    assert not row.passed


def test_no_value_agrees_with_no_value_and_with_nothing_else() -> None:
    assert compare("limit", [np.nan], [np.nan], 1e-4).passed
    assert not compare("limit", [2.0], [np.nan], 1e-4).passed
    assert not compare("limit", [np.nan], [2.0], 1e-4).passed


def test_a_reference_of_zero_is_met_exactly_or_measured_by_a_scale() -> None:
    assert compare("stress", 0.0, 0.0, 0.0).passed
    assert not compare("stress", 1e-9, 0.0, 1.0).passed
    assert compare("stress", 1e-3, 0.0, 1e-2, scale=1.0).passed


def test_an_error_is_small_on_either_side() -> None:
    assert below("error", -1e-9, 1e-8).passed
    assert not below("error", float("nan"), 1e-8).passed
