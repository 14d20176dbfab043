"""From result folders to an answer for every claim of the paper."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

from palpate.core import PalpateError
from palpate.grid.claim import CLAIMS, Answer, Finding, Verdict
from palpate.grid.claims_of_errors import judge_best, judge_height, judge_line, judge_markers, judge_thickness
from palpate.grid.claims_of_material import CONVERGENCE, judge_law, judge_mesh
from palpate.grid.claims_of_presses import (
    judge_deformation,
    judge_inversion,
    judge_stress,
    judge_travel_by_height,
    judge_travel_by_markers,
    judge_travel_by_thickness,
)
from palpate.grid.evidence import Evidence, MissingEvidenceError
from palpate.grid.io import read_grid

JUDGES: dict[str, Callable[[Evidence], Finding]] = {
    "C3": judge_stress,
    "C4": judge_deformation,
    "C5": judge_inversion,
    "C6": judge_travel_by_markers,
    "C7": judge_travel_by_height,
    "C8": judge_travel_by_thickness,
    "C9": judge_markers,
    "C10": judge_best,
    "C11": judge_height,
    "C12": judge_thickness,
    "C14": judge_line,
}
"""Claims that one grid decides."""


def read_evidence(folders: Sequence[Path]) -> tuple[tuple[Evidence, ...], Path | None]:
    """Read result folders: grids, and at most one convergence study.

    Raises
    ------
    PalpateError
        If a folder holds neither, or two hold a convergence study.
    """
    meshes = [folder for folder in folders if (folder / CONVERGENCE).is_file()]
    if len(meshes) > 1:
        raise PalpateError(f"{meshes[0]} and {meshes[1]} both hold a convergence study.", "Give one of them.")
    grids = tuple(Evidence(read_grid(folder), str(folder)) for folder in folders if folder not in meshes)
    return grids, meshes[0] if meshes else None


def evaluate_claims(grids: Sequence[Evidence], convergence: Path | None = None) -> tuple[Answer, ...]:
    """Answer every claim.

    Parameters
    ----------
    grids
        Studies of the paper's designs, one a contact law or way of learning.
    convergence
        Folder of `palpate convergence`, for C2.

    Returns
    -------
    tuple[Answer, ...]
        By claim, then in the order of the grids. A claim whose designs a grid does not have is not decided, and
        the answer names them.
    """
    answers = [
        Answer(CLAIMS["C1"], "Table 2", judge_law()),
        Answer(CLAIMS["C2"], "mesh study", judge_mesh(convergence)),
    ]
    names = name_sources(grids)
    for claim, judge in JUDGES.items():
        for evidence, name in zip(grids, names, strict=True):
            answers.append(Answer(CLAIMS[claim], name, _judge(judge, evidence)))
        if not grids:
            answers.append(Answer(CLAIMS[claim], "no grid", Finding(Verdict.OPEN, "", "needs a grid")))
    return tuple(answers)


def name_sources(grids: Sequence[Evidence]) -> tuple[str, ...]:
    """Name of each grid by what it is; two of the same kind are told apart by their folders."""
    kinds = Counter(evidence.label for evidence in grids)
    return tuple(e.label if kinds[e.label] == 1 else f"{e.label} ({e.folder})" for e in grids)


def _judge(judge: Callable[[Evidence], Finding], evidence: Evidence) -> Finding:
    try:
        return judge(evidence)
    except MissingEvidenceError as missing:
        return Finding(Verdict.OPEN, "", str(missing))
