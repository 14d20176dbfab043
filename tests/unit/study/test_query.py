import pytest

from errors import refused
from palpate.core import PalpateError
from palpate.study import filter_rows, sort_rows

ROWS = (
    {"height_mm": 10.0, "markers": 7, "max_error_deg": 3.0, "shape": "hemisphere"},
    {"height_mm": 20.0, "markers": 169, "max_error_deg": 0.8, "shape": "hemisphere"},
    {"height_mm": 30.0, "markers": 169, "max_error_deg": None, "shape": "spherical cap"},
)


def heights(rows):
    return [row["height_mm"] for row in rows]


@pytest.mark.parametrize(
    ("where", "kept"),
    [
        ("max_error_deg < 2 and height_mm <= 20", [20]),
        ("max_error_deg < 2 or height_mm == 10", [10, 20]),
        ("not markers == 169", [10]),
        ("10 < height_mm <= 30", [20, 30]),
        ("height_mm != 20", [10, 30]),
        ("height_mm > -15", [10, 20, 30]),
        ("shape == 'spherical cap'", [30]),
        ("markers > 100 and (height_mm < 25 or shape == 'hemisphere')", [20]),
        ("max_error_deg >= 0", [10, 20]),
        ("  markers == 7", [10]),
    ],
)
def test_questions_keep_the_rows_they_should(where, kept):
    assert heights(filter_rows(ROWS, where)) == kept


def test_an_unknown_column_names_the_nearest():
    with refused("column-unknown", "max_eror_deg", "max_error_deg"):
        filter_rows(ROWS, "height_mm > 100 and max_eror_deg < 2")


@pytest.mark.parametrize(
    "where",
    [
        "__import__('os').system('touch /tmp/never')",
        "height_mm.__class__ == 1",
        "[m for m in markers] == 1",
        "(lambda: 1)() == 1",
        "markers + 1 > 2",
        "markers ** 99999 > 2",
        "height_mm in (1, 2)",
        "markers is 7",
        "height_mm",
        "1",
        "markers == True",
        "markers == b'x'",
        "",
        "markers >",
        "markers = 7",
        "markers == 7; markers == 8",
        "(" * 300 + "markers == 7" + ")" * 300,
        "markers == 7 and " * 100 + "markers == 7",
        "markers == \x00",
    ],
)
def test_what_is_not_a_question_is_refused(where):
    with pytest.raises(PalpateError) as caught:
        filter_rows(ROWS, where)
    assert caught.value.code.startswith("question-") or caught.value.code == "column-unknown"


def test_a_text_is_not_compared_with_a_number():
    with refused("question-types-differ"):
        filter_rows(ROWS, "shape < 3")


def test_sorting_rises_and_a_minus_reverses_and_nothing_comes_last():
    assert heights(sort_rows(ROWS, "max_error_deg")) == [20, 10, 30]
    assert heights(sort_rows(ROWS, "-max_error_deg")) == [10, 20, 30]
    assert heights(sort_rows(ROWS, "-shape")) == [30, 10, 20]


@pytest.mark.parametrize(
    ("by", "order"),
    [
        ("max_error_deg desc", [10, 20, 30]),
        ("max_error_deg DESC", [10, 20, 30]),
        ("max_error_deg asc", [20, 10, 30]),
        (" -max_error_deg ", [10, 20, 30]),
    ],
)
def test_sorting_takes_the_direction_as_a_word(by, order):
    assert heights(sort_rows(ROWS, by)) == order


@pytest.mark.parametrize("by", ["", "-", "markers down", "-markers desc", "markers desc desc"])
def test_an_order_that_is_none_is_refused(by):
    with refused("column-unknown"):
        sort_rows(ROWS, by)


def test_sorting_by_an_unknown_column_names_the_nearest():
    with refused("column-unknown", "markers"):
        sort_rows(ROWS, "-marker")


def test_an_empty_grid_answers_with_nothing():
    assert filter_rows((), "markers > 1") == ()
    assert sort_rows((), "markers") == ()
