"""Run of the suite's cases, with their outcomes."""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fnmatch import fnmatch

from palpate.core import PalpateError
from palpate.verify.case import Case, Row
from palpate.verify.cases import CASES


@dataclass(frozen=True)
class CaseOutcome:
    """Outcome of a case.

    Attributes
    ----------
    case
        The case.
    rows
        Its rows; empty if it failed.
    cpu_s
        CPU seconds.
    failure
        Reason of the failure; empty otherwise.
    """

    case: Case
    rows: tuple[Row, ...]
    cpu_s: float
    failure: str = ""

    @property
    def passed(self) -> bool:
        """Whether every row is within its tolerance."""
        return not self.failure and all(row.passed for row in self.rows)


def choose_cases(only: str | None = None) -> tuple[Case, ...]:
    """Choose the cases whose name matches a pattern (``*`` and ``?`` allowed), by default all.

    Raises
    ------
    PalpateError
        If no case matches.
    """
    named = tuple(case for case in CASES if only is None or fnmatch(case.name, f"*{only}*"))
    if not named:
        names = ", ".join(case.name for case in CASES)
        raise PalpateError(
            f"No case of the verification suite is named like '{only}'.", f"There are {names}.", code="case-unknown"
        )
    return named


def run_cases(cases: Iterable[Case]) -> Iterator[CaseOutcome]:
    """Run cases one by one; one that cannot be solved is an outcome without rows."""
    for case in cases:
        started = time.process_time()
        try:
            rows, failure = tuple(case.run()), ""
        except PalpateError as error:
            rows, failure = (), error.problem
        yield CaseOutcome(case, rows, time.process_time() - started, failure)
