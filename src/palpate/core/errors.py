"""The one family of errors that reaches a user: a sentence with the number, and the remedy."""

from __future__ import annotations


class PalpateError(Exception):
    """Something the user can mend. The command line prints it on one screen and exits with code 2.

    Parameters
    ----------
    what
        One sentence that says what is wrong, with the offending number and its unit.
    remedy
        What to do about it, in one sentence; empty where the sentence already says so.
    """

    def __init__(self, what: str, remedy: str = "") -> None:
        super().__init__(f"{what} {remedy}".strip())
        self.what = what
        self.remedy = remedy

    @classmethod
    def of(cls, error: BaseException) -> PalpateError:
        """Any error as one of this family: itself, or one line with the kind of what a library raised."""
        if isinstance(error, PalpateError):
            return error
        first = next(iter(str(error).strip().splitlines()), "")
        return PalpateError(f"{type(error).__name__}: {first}".rstrip(": "))


class MissingExtraError(PalpateError):
    """An optional library is not installed.

    Parameters
    ----------
    library
        Name of the library that could not be imported.
    extra
        The extra of this package that installs it.
    """

    def __init__(self, library: str, extra: str) -> None:
        super().__init__(
            f"This needs {library}, which is not installed.",
            f'Install it with: pip install "palpate[{extra}]"',
        )
