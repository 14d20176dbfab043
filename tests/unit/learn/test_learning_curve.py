"""The sentence below a learning curve."""

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
