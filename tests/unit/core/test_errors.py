import pickle

from errors import check_values
from palpate.core import MissingExtraError, PalpateError


def test_an_error_keeps_sentence_and_remedy_apart() -> None:
    error = PalpateError("The wall is 0 mm thick.", "Give more than 0.2 mm.", code="wall-not-positive")
    assert (error.problem, error.remedy) == ("The wall is 0 mm thick.", "Give more than 0.2 mm.")
    assert str(error) == "The wall is 0 mm thick. Give more than 0.2 mm."


def test_a_missing_extra_says_what_to_install() -> None:
    error = MissingExtraError("torch", "learn")
    assert 'pip install -e ".[learn]"' in str(error)
    assert error.code == "extra-missing"


def test_an_error_keeps_its_code_from_one_process_to_another() -> None:
    for error in (PalpateError("No.", "Go.", code="no-way"), MissingExtraError("torch", "learn")):
        copy = pickle.loads(pickle.dumps(error))
        assert (type(copy), copy.problem, copy.remedy, copy.code) == (
            type(error),
            error.problem,
            error.remedy,
            error.code,
        )
        assert str(copy) == str(error)


def test_any_error_is_told_in_one_line() -> None:
    own = PalpateError("It is too thin.", "Make it thicker.", code="no-way")
    assert PalpateError.of(own) is own
    told = PalpateError.of(ValueError("bad shape\nmore"))
    assert told.code == "library-error"
    check_values(told.problem, "ValueError", "bad shape")
    assert "more" not in told.problem
    check_values(PalpateError.of(KeyboardInterrupt()).problem, "KeyboardInterrupt")
