"""`palpate claims`: finished studies held against the claims of the paper."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.cli.flag import JsonFlag
from palpate.cli.output import print_json, print_table

if TYPE_CHECKING:
    from palpate.claims import ClaimAnswer

_FOLDERS = "Result folders of studies of the paper's designs, of `palpate twin`, and of `palpate convergence --out`."


def claims(
    *results: Annotated[Path, Parameter(help=_FOLDERS)],
    out: Annotated[
        Path | None, Parameter(name=["--out", "-o"], help="Page to write, .md or .html, with pictures beside it.")
    ] = None,
    json: JsonFlag = False,
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
    if json:
        print_json([_describe(answer) for answer in answers])
    else:
        _print(answers)
        if out is not None:
            print(f"Page: {out}")


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


def _print(answers: Sequence[ClaimAnswer]) -> None:
    rows = [
        [
            answer.claim.name,
            answer.claim.statement,
            answer.source,
            "; ".join(part for part in (answer.finding.figures, answer.finding.why) if part),
            str(answer.finding.verdict),
        ]
        for answer in answers
    ]
    print_table("the paper's claims", ["", "the paper", "in", "figures", "verdict"], rows)
