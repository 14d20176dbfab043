"""The sentence below a learning curve."""

import pytest

from errors import check_values
from palpate.learn.learning_curve import CurvePoint, extrapolate_learning_curve


def test_an_error_that_grows_with_the_presses_is_reported_as_a_rise() -> None:
    found = [
        extrapolate_learning_curve([CurvePoint(10, "ridge", (0.1,)), CurvePoint(14, "ridge", (x,))])
        for x in (0.05, 0.15)
    ]
    assert [sentence.split(";")[0] for sentence in found] == [
        "From 10 to 14 presses the error fell by 50%",
        "From 10 to 14 presses the error rose by 50%",
    ]


def test_an_error_that_rises_gives_no_verdict() -> None:
    sentence = extrapolate_learning_curve([CurvePoint(10, "ridge", (0.1,)), CurvePoint(14, "ridge", (0.15,))])
    assert "enough" not in sentence
    assert "would" not in sentence


def test_points_from_scratch_and_adapted_ones_are_not_mixed() -> None:
    scratch = [CurvePoint(10, "ridge", (0.4,)), CurvePoint(14, "ridge", (0.2,))]
    adapted = [CurvePoint(0, "mine as it is", (0.3,)), CurvePoint(14, "adapted", (0.1,))]
    assert extrapolate_learning_curve([*scratch, *adapted]).startswith("From 10 to 14 presses the error fell by 50%")
    assert extrapolate_learning_curve(adapted) == ""
    more = [*scratch, *adapted, CurvePoint(20, "adapted", (0.09,))]
    assert extrapolate_learning_curve(more).startswith("From 14 to 20 presses the error fell by 10%")


@pytest.mark.parametrize(("ratio", "fell", "gain"), [(0.5, "50%", "29%"), (0.25, "75%", "50%"), (0.9, "10%", "5%")])
def test_twice_as_many_presses_go_on_by_the_same_power(ratio: float, fell: str, gain: str) -> None:
    """From 10 to 40 presses an error falls by r = 4^-a: by 1 - 2^-a = 1 - sqrt(r) from there to 80."""
    points = [CurvePoint(10, "ridge", (0.4, 0.2)), CurvePoint(40, "ridge", (0.4 * ratio, 0.2 * ratio))]
    check_values(extrapolate_learning_curve(points), 10, 40, fell, gain)
