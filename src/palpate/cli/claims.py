"""`palpate claims`: finished studies held against the claims of the paper."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.cli.output import Output
from palpate.core.report import Column, Report

if TYPE_CHECKING:
    from palpate.claims import ClaimAnswer

_COLUMNS = (
    Column("claim"),
    Column("statement", "the paper", prose=True),
    Column("source", "in", prose=True, deciding=False),
    Column("figures", prose=True),
    Column("verdict"),
)
_FOLDERS = "Result folders of studies of the paper's designs, of `palpate twin`, and of `palpate convergence --out`."


def claims(
    *results: Annotated[Path, Parameter(help=_FOLDERS)],
    out: Annotated[
        Path | None, Parameter(name=["--out", "-o"], help="Page to write, .md or .html, with pictures beside it.")
    ] = None,
    output: Output = Output(),
) -> None:
    """Say of every claim of the paper whether it holds, with the figures that decide.

    Give one result folder, or one a contact law. A claim whose designs are not there is not decided.
    """
    from palpate.claims import assess_claims, read_evidence, write_claims

    grids, meshes = read_evidence(results)
    answers = assess_claims(grids, meshes)
    if out is not None:
        words = ["palpate", "claims", *(str(folder) for folder in results), "--out", str(out)]
        write_claims(out, answers, grids, shlex.join(words))
    table = Report("the paper's claims", _COLUMNS, [_row(answer) for answer in answers], file=str(out or ""))
    output.show([_describe(answer) for answer in answers], table, *([f"Page: {out}"] if out is not None else []))


def _describe(answer: ClaimAnswer) -> dict[str, Any]:
    return {
        "claim": answer.claim.name,
        "statement": answer.claim.statement,
        "test": answer.claim.test,
        "source": answer.source,
        "verdict": str(answer.finding.verdict),
        "figures": answer.finding.figures,
        "why": answer.finding.why,
    }


def _row(answer: ClaimAnswer) -> dict[str, Any]:
    found = answer.finding
    figures = "; ".join(part for part in (found.figures, found.why) if part)
    return {**_describe(answer), "figures": figures}
