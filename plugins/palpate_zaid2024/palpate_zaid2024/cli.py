"""`palpate claims`: comparison of finished studies with the claims of the paper."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.cli.output import Output, check_file, check_folder
from palpate.cli.progress import show_progress

if TYPE_CHECKING:
    from palpate_zaid2024 import ClaimAnswer

_FOLDERS = (
    "Result folders of studies of the paper's designs, of `palpate calibration predict`, and of "
    "`palpate design convergence --out`."
)
_FIGURES = (
    "Folder for a page of Tables 2 and 3 and Figs. 8 to 12 of the paper in this version, with the printed "
    "values. Six domes are pressed for it, about a minute."
)


def claims(
    *results: Annotated[Path, Parameter(help=_FOLDERS)],
    out: Annotated[
        Path | None,
        Parameter(name=["--out", "-o"], help="Page to write, .md or .html; its pictures are written next to it."),
    ] = None,
    figures: Annotated[Path | None, Parameter(name="--figures", help=_FIGURES)] = None,
    output: Output = Output(),
) -> None:
    """Test every claim of the paper, and print the verdicts with the figures that decide.

    Give one result folder, or one per contact law. A claim is not decided if its designs are missing.
    """
    from palpate_zaid2024 import assess_claims, claim_report, read_evidence, write_claims, write_figures

    check_file(out, ".md", ".html")
    check_folder(figures)
    grids, meshes = read_evidence(results)
    answers = assess_claims(grids, meshes)
    if out is not None:
        words = ["palpate", "claims", *(str(folder) for folder in results), "--out", str(out)]
        write_claims(out, answers, grids, shlex.join(words))
    page = [f"Page: {out}"] if out is not None else []
    if figures is not None:
        with show_progress(quiet=output.json) as progress:
            page.append(f"Figures: {write_figures(figures, answers, grids, meshes, progress)}")
    output.show([_describe(answer) for answer in answers], "The paper's claims", claim_report(answers), *page)


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
