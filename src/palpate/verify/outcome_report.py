"""Table of the outcomes of cases."""

from __future__ import annotations

from collections.abc import Sequence

from palpate.core.report import Column, Report
from palpate.verify.run_cases import CaseOutcome

COLUMNS = (
    Column("case"),
    Column("reference", deciding=False, prose=True),
    Column("quantity", prose=True),
    Column("values", deciding=False, meaning="number of values compared, of which this deviates most"),
    Column("ours", deciding=False),
    Column("expected", "reference value", deciding=False),
    Column("deviation", meaning="difference from the reference, as a share of it"),
    Column("tolerance", meaning="largest deviation that passes"),
    Column("pass"),
)


def format_number(value: float) -> str:
    """Format a value with five digits."""
    return f"{value:.5g}"


def format_deviation(value: float) -> str:
    """Format a deviation or tolerance in percent, or as a power of ten if it is small."""
    return f"{100 * value:.2f} %" if value >= 1e-4 else "0" if value == 0 else f"{value:.0e}"


def outcome_report(outcomes: Sequence[CaseOutcome]) -> Report:
    """Build the table of deviations; a case that could not be solved has one row with the reason."""
    rows: list[dict[str, object]] = []
    for outcome in outcomes:
        case = {"case": outcome.case.name, "reference": outcome.case.reference}
        rows += [
            {
                **case,
                "quantity": f"{row.quantity} at {row.at}" if row.at else row.quantity,
                "values": row.count,
                "ours": format_number(row.ours),
                "expected": format_number(row.reference),
                "deviation": format_deviation(row.deviation),
                "tolerance": format_deviation(row.tolerance),
                "pass": "yes" if row.passed else "NO",
            }
            for row in outcome.rows
        ]
        if outcome.failure:
            rows.append({**case, "quantity": outcome.failure, "pass": "NO"})
    passed = sum(row["pass"] == "yes" for row in rows)
    seconds = sum(outcome.cpu_s for outcome in outcomes)
    return Report("verification", COLUMNS, rows, (f"{passed} of {len(rows)} rows pass, {seconds:.1f} CPU-seconds.",))
