"""Every case: each row within its tolerance."""

import pytest

from palpate.verify import CASES, Case
from validation.cases import LONG_CASES, PUBLISHED_CASES, SLOW


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, id=case.name, marks=[pytest.mark.slow(30)] if case.name in SLOW else [])
        for case in (*CASES, *LONG_CASES, *PUBLISHED_CASES)
    ],
)
def test_every_row_is_within_its_tolerance(case: Case) -> None:
    rows = case.run()
    if not rows:
        pytest.fail("no row")
    assert [row for row in rows if not row.passed] == []
