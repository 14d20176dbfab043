"""The page of the documentation that shows the suite, written from its outcomes."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import date

from palpate.core import provenance
from palpate.core.report import Column, Report, page_markdown
from palpate.verify.run_cases import CaseOutcome

_HEAD = """# Verification

Problems with known answers, solved by the elements, contact and Newton's method of the package itself. Every row is
the value that deviates most among those compared. A deviation is relative to the reference unless the quantity says
over what it is taken. References marked *exact* are closed forms, quadratures or ordinary differential equations;
codes are independent of this package; a *property* needs no number from outside."""
_NOTES = """
## Notes

* *Incompressible references* are solved at K/µ = 100 000. The default of the package, 2000, alone lowers the pressure
  of a sphere inflated threefold by 0.4 %.
* *Hertz* is the limit of a small patch: the sphere between plates is some 0.27 a/R stiffer (1.9 % at d/R = 0.005),
  so the ratio carried to a/R = 0 stands beside the values.
* *Shell between plates*: the reference is thin-shell theory, which differs from a solid by the order of h/R. At
  R/h = 20 that is 2 to 5 %, the same to 0.2 % on a mesh of twice the layers and half the cell, and under a contact
  eight times as stiff; h/R is therefore added to the 2 % there. The ratio to the reference, carried to h/R = 0 by a
  line through R/h = 20, 50 and 100, is held to 2 % in rows of its own.
* *Clamped caps*: digitised curves (AQUINAS-FE, BSD-3-Clause) whose two codes differ by up to 11 % of the load where
  it is steep; so points are held by their distance from our curve, each axis over its greatest value, and single
  figures by the nearest within the range of the codes. Pressure keeps the direction that it had at rest.
* *Published experiments and codes* have a page each, with source, error of reading, mesh, control and what could not
  be had: {doc}`published/index`.
* *Domes* are pressed by the product's default mesh and contact, but for the thickest (two cells through the wall) and
  the pair against CalculiX, whose reference is itself a coarse mesh with soft contact.
"""
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
_VERSIONS = ("palpate", "python", "numpy", "scipy", "py-mkl-pardiso", "rslab")
"""What the page says it was made with."""


def format_number(value: float) -> str:
    """Format a value with five digits."""
    return f"{value:.5g}"


def format_deviation(value: float) -> str:
    """Format a deviation or tolerance in percent, or as a power of ten where it is small."""
    return f"{100 * value:.2f} %" if value >= 1e-4 else "0" if value == 0 else f"{value:.0e}"


def write_page(outcomes: Sequence[CaseOutcome], command: str) -> str:
    """Write the page.

    Parameters
    ----------
    outcomes
        Of the cases, in their order.
    command
        The command that made it.

    Returns
    -------
    str
        Markdown.
    """
    rows = [row for outcome in outcomes for row in outcome.rows]
    passed = sum(row.passed for row in rows)
    failed = sum(bool(outcome.failure) for outcome in outcomes)
    versions = ", ".join(f"{name} {version}" for name, version in provenance().items() if name in _VERSIONS)
    seconds = sum(item.cpu_s for item in outcomes)
    times = [(item.case.name, f"{item.cpu_s:.1f}") for item in outcomes]
    parts: list[str | Report] = [
        _HEAD,
        f"Made by `{command}` on {date.today().isoformat()} in {seconds:.0f} CPU-seconds "
        f"on one core ({versions}). {passed} of {len(rows)} rows pass"
        + (f"; {failed} cases could not be solved." if failed else "."),
        outcome_report(outcomes),
        Report.of("", ("case", "CPU s"), times),
        _NOTES.strip(),
    ]
    return page_markdown(parts)


def outcome_report(outcomes: Sequence[CaseOutcome]) -> Report:
    """Rows of the cases with their deviations, one row for a case that could not be solved."""
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
