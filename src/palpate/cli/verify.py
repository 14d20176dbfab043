"""`palpate verify`: solve problems with known solutions and report the deviations."""

from __future__ import annotations

import sys
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.cli.border import OUTSIDE
from palpate.cli.output import Output

if TYPE_CHECKING:
    from palpate.verify import CaseOutcome

_ONLY = "Run only the cases whose name contains this text; * and ? are wildcards."


def verify(
    *,
    only: Annotated[str | None, Parameter(help=_ONLY)] = None,
    output: Output = Output(),
) -> int:
    """Solve problems with known solutions and report the deviations."""
    from palpate.verify import choose_cases, outcome_report, run_cases

    outcomes = []
    for outcome in run_cases(choose_cases(only)):
        outcomes.append(outcome)
        state = "passed" if outcome.passed else "FAILED"
        print(f"{outcome.case.name}: {state}, {outcome.cpu_s:.1f} CPU-seconds", file=sys.stderr)
    output.show(describe_outcomes(outcomes), outcome_report(outcomes))
    return 0 if all(outcome.passed for outcome in outcomes) else OUTSIDE


def describe_outcomes(outcomes: list[CaseOutcome]) -> dict[str, Any]:
    """Return outcomes as JSON data."""
    cases = [
        {
            "case": outcome.case.name,
            "reference": outcome.case.reference,
            "cpu_s": outcome.cpu_s,
            "failure": outcome.failure,
            "rows": [asdict(row) | {"passed": row.passed} for row in outcome.rows],
        }
        for outcome in outcomes
    ]
    return {"passed": all(outcome.passed for outcome in outcomes), "cases": cases}
