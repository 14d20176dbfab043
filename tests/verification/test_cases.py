"""Every case of the verification suite: each row within its tolerance."""

import pytest

from palpate.verify import CASES, Case

THICK_SHELL = "a solid shell of R/h = 20 differs from thin-shell theory by the order of h/R"
KNOWN_MISSES = {"shell_R20_flat": THICK_SHELL, "shell_R20_inverted": THICK_SHELL}


def mark(case: Case) -> list[pytest.MarkDecorator]:
    slow = [pytest.mark.slow] if case.slow else []
    miss = KNOWN_MISSES.get(case.name)
    return slow if miss is None else [*slow, pytest.mark.xfail(reason=miss, strict=True, raises=AssertionError)]


@pytest.mark.parametrize("case", [pytest.param(case, id=case.name, marks=mark(case)) for case in CASES])
def test_every_row_is_within_its_tolerance(case: Case) -> None:
    rows = case.run()
    if not rows:
        pytest.fail("no row")
    assert [row for row in rows if not row.passed] == []
