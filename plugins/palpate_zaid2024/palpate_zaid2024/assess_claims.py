"""Assessment of every claim of the paper from result folders."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

from palpate.study import read_grid
from palpate_zaid2024.assess_errors import assess_best, assess_height, assess_line, assess_markers, assess_thickness
from palpate_zaid2024.assess_material import CONVERGENCE, assess_law, assess_mesh
from palpate_zaid2024.assess_presses import (
    assess_deformation,
    assess_inversion,
    assess_stress,
    assess_travel_by_height,
    assess_travel_by_markers,
    assess_travel_by_thickness,
)
from palpate_zaid2024.claim import CLAIMS, ClaimAnswer, ClaimFinding, Verdict
from palpate_zaid2024.evidence import Evidence, MissingEvidenceError, read_built

ASSESSMENTS: dict[str, Callable[[Evidence], ClaimFinding]] = {
    "C3": assess_stress,
    "C4": assess_deformation,
    "C5": assess_inversion,
    "C6": assess_travel_by_markers,
    "C7": assess_travel_by_height,
    "C8": assess_travel_by_thickness,
    "C9": assess_markers,
    "C10": assess_best,
    "C11": assess_height,
    "C12": assess_thickness,
    "C14": assess_line,
}
"""Claims that one grid decides."""


BUILT = Path("twins", "built.csv")
"""Table of predicted accuracy in a result folder of `palpate calibration predict`."""
NO_MESHES = ClaimFinding(Verdict.UNDECIDED, "", "needs the folder of `palpate design convergence --out FOLDER`")


def read_evidence(folders: Sequence[Path]) -> tuple[tuple[Evidence, ...], tuple[Path, ...]]:
    """Read grids and tables of convergence studies from result folders.

    The accuracy of built units predicted by `palpate calibration predict`, over all frictions, joins the first grid.

    Raises
    ------
    PalpateError
        If a folder contains none of these.
    """
    meshes = {folder: sorted(folder.glob(CONVERGENCE)) for folder in folders}
    built = [folder for folder in folders if (folder / BUILT).is_file() and not (folder / "grid.json").is_file()]
    studies = [folder for folder in folders if not meshes[folder] and folder not in built]
    beside = {design: row for folder in built for design, row in read_built(folder / BUILT).items()}
    grids = tuple(
        Evidence(read_grid(folder), str(folder), {} if number else beside) for number, folder in enumerate(studies)
    )
    return grids, tuple(path for paths in meshes.values() for path in paths)


def assess_claims(grids: Sequence[Evidence], meshes: Sequence[Path] = ()) -> tuple[ClaimAnswer, ...]:
    """Assess every claim.

    Parameters
    ----------
    grids
        Studies of the paper's designs, one per contact law or learning preset.
    meshes
        Tables of `palpate design convergence`, for C2.

    Returns
    -------
    tuple[ClaimAnswer, ...]
        By claim, then in the order of the grids. A claim is not decided if designs are missing; the answer names
        them.
    """
    answers = [ClaimAnswer(CLAIMS["C1"], "Table 2", assess_law())]
    answers += [ClaimAnswer(CLAIMS["C2"], _name_meshes(path), assess_mesh(path)) for path in meshes]
    if not meshes:
        answers.append(ClaimAnswer(CLAIMS["C2"], "no mesh study", NO_MESHES))
    names = name_sources(grids)
    for claim, judge in ASSESSMENTS.items():
        for evidence, name in zip(grids, names, strict=True):
            answers.append(ClaimAnswer(CLAIMS[claim], name, _assess(judge, evidence)))
        if not grids:
            answers.append(ClaimAnswer(CLAIMS[claim], "no grid", ClaimFinding(Verdict.UNDECIDED, "", "needs a grid")))
    return tuple(answers)


def name_sources(grids: Sequence[Evidence]) -> tuple[str, ...]:
    """Return the label of each grid; equal labels are distinguished by their folders."""
    kinds = Counter(evidence.label for evidence in grids)
    return tuple(e.label if kinds[e.label] == 1 else f"{e.label} ({e.folder})" for e in grids)


def _name_meshes(path: Path) -> str:
    """Return a name such as ``"mesh study, no slip"`` for ``convergence_no_slip.csv``."""
    return ", ".join(["mesh study", *path.stem.split("_", 1)[1:]]).replace("_", " ")


def _assess(assess: Callable[[Evidence], ClaimFinding], evidence: Evidence) -> ClaimFinding:
    try:
        return assess(evidence)
    except MissingEvidenceError as missing:
        return ClaimFinding(Verdict.UNDECIDED, "", str(missing))
