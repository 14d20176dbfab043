"""`palpate verify`: solve problems with known answers and show how near ours are."""

from __future__ import annotations

import sys
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from palpate.cli.flag import JsonFlag
from palpate.cli.output import check_file, print_json, print_table
from palpate.verify import CaseOutcome, choose_cases, format_deviation, format_number, run_cases, write_page

OUTSIDE = 1
"""Exit code where a row is outside its tolerance."""
_ONLY = "Run the cases whose name holds this; * and ? stand for what they do in file names."
_COLUMNS = ["case", "reference", "quantity", "ours", "reference value", "deviation", "tolerance", "pass"]


def verify(
    *,
    only: Annotated[str | None, Parameter(help=_ONLY)] = None,
    quick: Annotated[bool, Parameter(negative="", help="Leave out the slow cases.")] = False,
    markdown: Annotated[Path | None, Parameter(help="Write the page of the documentation to this file.")] = None,
    json: JsonFlag = False,
) -> int:
    """Solve problems with known answers and show how near ours are."""
    check_file(markdown)
    outcomes = []
    for outcome in run_cases(choose_cases(only, quick=quick)):
        outcomes.append(outcome)
        state = "passed" if outcome.passed else "FAILED"
        print(f"{outcome.case.name}: {state}, {outcome.cpu_s:.1f} CPU-seconds", file=sys.stderr)
    if markdown is not None:
        markdown.write_text(write_page(outcomes, _command(only, quick, markdown)), encoding="utf-8")
    if json:
        print_json(describe_outcomes(outcomes))
    else:
        _print_outcomes(outcomes)
    return 0 if all(outcome.passed for outcome in outcomes) else OUTSIDE


def describe_outcomes(outcomes: list[CaseOutcome]) -> dict[str, Any]:
    """Outcomes as JSON data."""
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


def _print_outcomes(outcomes: list[CaseOutcome]) -> None:
    rows = [
        [
            outcome.case.name,
            outcome.case.reference,
            f"{row.quantity} at {row.at}" if row.at else row.quantity,
            format_number(row.ours),
            format_number(row.reference),
            format_deviation(row.deviation),
            format_deviation(row.tolerance),
            "yes" if row.passed else "NO",
        ]
        for outcome in outcomes
        for row in outcome.rows
    ]
    failed = [outcome for outcome in outcomes if outcome.failure]
    rows += [[item.case.name, item.case.reference, item.failure, *[""] * 4, "NO"] for item in failed]
    print_table("verification", _COLUMNS, rows)
    passed = sum(row.passed for outcome in outcomes for row in outcome.rows)
    count = sum(len(outcome.rows) for outcome in outcomes) + len(failed)
    print(f"{passed} of {count} rows pass, {sum(outcome.cpu_s for outcome in outcomes):.1f} CPU-seconds.")
