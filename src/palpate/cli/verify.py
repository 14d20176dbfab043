"""`palpate verify`: solve problems with known solutions and report the deviations."""

from __future__ import annotations

import sys
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from palpate.cli.output import Output, check_file
from palpate.verify import CaseOutcome, choose_cases, outcome_report, run_cases, write_page

OUTSIDE = 1
"""Exit code if a row is outside its tolerance."""
_ONLY = "Run only the cases whose name contains this text; * and ? are wildcards."


def verify(
    *,
    only: Annotated[str | None, Parameter(help=_ONLY)] = None,
    quick: Annotated[bool, Parameter(negative="", help="Leave out the slow cases.")] = False,
    markdown: Annotated[Path | None, Parameter(help="Write the page of the documentation to this file.")] = None,
    output: Output = Output(),
) -> int:
    """Solve problems with known solutions and report the deviations."""
    check_file(markdown)
    outcomes = []
    for outcome in run_cases(choose_cases(only, quick=quick)):
        outcomes.append(outcome)
        state = "passed" if outcome.passed else "FAILED"
        print(f"{outcome.case.name}: {state}, {outcome.cpu_s:.1f} CPU-seconds", file=sys.stderr)
    if markdown is not None:
        markdown.write_text(write_page(outcomes, _command(only, quick, markdown)), encoding="utf-8")
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


def _command(only: str | None, quick: bool, markdown: Path) -> str:
    words = ["palpate verify", *(["--only", only] if only else []), *(["--quick"] if quick else [])]
    return " ".join([*words, "--markdown", markdown.as_posix()])
