"""What is refused: by its code and the values that its message names, never by a sentence."""

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
from pydantic import ValidationError

from palpate.core import PalpateError


@contextmanager
def refused(
    code: str | tuple[str, ...], *values: object
) -> Iterator[pytest.ExceptionInfo[PalpateError | ValidationError]]:
    """The block raises an error of this code, or of one of these, and its message names every value."""
    with pytest.raises((PalpateError, ValidationError)) as caught:
        yield caught
    assert code_of(caught.value) in ((code,) if isinstance(code, str) else code), str(caught.value)
    check_values(str(caught.value), *values)


def code_of(error: PalpateError | ValidationError) -> str:
    """The code of an error; that of a spec is the type of its first fault."""
    return error.errors()[0]["type"] if isinstance(error, ValidationError) else error.code


def check_refusal(said: str, code: str | tuple[str, ...], *values: object) -> None:
    """The command line ended by an error of this code, or of one of these, and its message names every value."""
    codes = (code,) if isinstance(code, str) else code
    assert any(f" [{one}]\n" in f"{said}\n" for one in codes), said
    check_values(said, *values)


def check_values(text: str, *values: object) -> None:
    """Every value stands in a text: words as they are, a number as a whole one."""
    for value in values:
        words = str(value)
        whole = r"(?<![\d.])" if re.match(r"\d", words) else ""
        end = r"(?!\d|\.\d)" if re.search(r"\d$", words) else ""
        assert re.search(whole + re.escape(words) + end, text), f"{words!r} is not in {text!r}"


def end_process(*_: object) -> None:
    """End this process at once, as a crash of a library does; workers find it here by its name."""
    os._exit(139)
