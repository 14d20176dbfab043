"""The one family of errors that reaches a user: a sentence with the number, the remedy, and a code to search for."""

from __future__ import annotations

from typing import Any


class PalpateError(Exception):
    """Something the user can mend. The command line prints it on one screen and exits with code 2.

    Parameters
    ----------
    problem
        One sentence that says what is wrong, with the offending number and its unit.
    remedy
        What to do about it, in one sentence; empty where the sentence already says so.
    code
        Short name of the kind of error that does not change, e.g. ``"column-missing"``.
    """

    def __init__(self, problem: str, remedy: str = "", *, code: str) -> None:
        super().__init__(f"{problem} {remedy}".strip())
        self.problem = problem
        self.remedy = remedy
        self.code = code

    def __reduce__(self) -> tuple[Any, ...]:
        return _unpickle, (type(self), self.args), self.__dict__

    @classmethod
    def of(cls, error: BaseException) -> PalpateError:
        """Return an error of this family as it is, and any other one as a sentence with its kind."""
        if isinstance(error, PalpateError):
            return error
        first = next(iter(str(error).strip().splitlines()), "")
        raised = f"{type(error).__name__}: {first}".rstrip(":. ")
        return PalpateError(f"A library raised {raised}.", "Check the input.", code="library-error")


def _unpickle(kind: type[PalpateError], args: tuple[Any, ...]) -> PalpateError:
    """An error as it was, whatever its class is made from."""
    return kind.__new__(kind, *args)


class MissingExtraError(PalpateError):
    """An optional library is not installed.

    Parameters
    ----------
    library
        Name of the library that could not be imported.
    extra
        The extra of this package that installs it.
    """

    code = "extra-missing"

    def __init__(self, library: str, extra: str) -> None:
        super().__init__(
            f"This needs {library}, which is not installed.",
            f'Install it with: pip install "palpate[{extra}]"',
            code=self.code,
        )
