"""Verify: problems with known answers, solved by the package's own element, contact and Newton's method."""

from palpate.verify.case import Case, Row
from palpate.verify.cases import CASES
from palpate.verify.outcome_report import outcome_report
from palpate.verify.run_cases import CaseOutcome, choose_cases, run_cases

__all__ = [
    "CASES",
    "Case",
    "CaseOutcome",
    "Row",
    "choose_cases",
    "outcome_report",
    "run_cases",
]
