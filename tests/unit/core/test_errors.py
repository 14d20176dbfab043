from palpate.core import MissingExtraError, PalpateError


def test_an_error_keeps_sentence_and_remedy_apart() -> None:
    error = PalpateError("The wall is 0 mm thick.", "Give more than 0.2 mm.")
    assert (error.what, error.remedy) == ("The wall is 0 mm thick.", "Give more than 0.2 mm.")
    assert str(error) == "The wall is 0 mm thick. Give more than 0.2 mm."


def test_a_missing_extra_says_what_to_install() -> None:
    assert 'pip install "palpate[learn]"' in str(MissingExtraError("torch", "learn"))


def test_any_error_is_told_in_one_line() -> None:
    own = PalpateError("It is too thin.", "Make it thicker.")
    assert PalpateError.of(own) is own
    assert PalpateError.of(ValueError("bad shape\nmore")).what == "ValueError: bad shape"
    assert PalpateError.of(KeyboardInterrupt()).what == "KeyboardInterrupt"
