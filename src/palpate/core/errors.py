"""Errors for the user: a sentence with the value, the remedy, and a code to search for."""

from __future__ import annotations

from typing import Any


class PalpateError(Exception):
    """Error that the user can correct. The command line prints it on one screen and exits with code 2.

    Parameters
    ----------
    problem
        One sentence that states the problem, with the value and its unit.
    remedy
        Recommended action, in one sentence; empty if the problem contains it.
    code
        Permanent short name of the kind of error, e.g. ``"column-missing"``.
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
        """Return an error of this family unchanged, and any other one as a sentence with its kind."""
        if isinstance(error, PalpateError):
            return error
        first = next(iter(str(error).strip().splitlines()), "")
        raised = f"{type(error).__name__}: {first}".rstrip(":. ")
        return PalpateError(f"A library raised {raised}.", "Check the input.", code="library-error")


def _unpickle(kind: type[PalpateError], args: tuple[Any, ...]) -> PalpateError:
    """Rebuild an error without calling its class's constructor."""
    return kind.__new__(kind, *args)


class MissingExtraError(PalpateError):
    """Error of an optional library that is not installed, with the extra that installs it."""

    code = "extra-missing"

    def __init__(self, library: str, extra: str) -> None:
        super().__init__(
            f"This needs {library}, which is not installed.",
            f'Install it in the folder of palpate: pip install -e ".[{extra}]"',
            code=self.code,
        )
