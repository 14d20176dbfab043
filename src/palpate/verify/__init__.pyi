"""Verify: problems with known answers, solved by the package's own element, contact and Newton's method."""

from palpate.verify.case import Case, Row
from palpate.verify.cases import CASES
from palpate.verify.published import PUBLISHED, published_pages
from palpate.verify.run_cases import CaseOutcome, choose_cases, run_cases
from palpate.verify.write_page import outcome_report, write_page

__all__ = [
    "CASES",
    "PUBLISHED",
    "Case",
    "CaseOutcome",
    "Row",
    "choose_cases",
    "outcome_report",
    "published_pages",
    "run_cases",
    "write_page",
]
