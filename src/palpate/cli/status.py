"""`palpate study status`: progress of a study."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.cli.output import OutFlag, Output
from palpate.core import PalpateError
from palpate.core.report import Column, Report

if TYPE_CHECKING:
    from palpate.study import StudyStatus

_COLUMNS = (
    Column("kind", "artefact"),
    Column("made"),
    Column("total"),
    Column("working", "in progress"),
    Column("quarantined", meaning="broken files moved to quarantine"),
    Column("remaining_s", "remaining, one core", form=".0f"),
)


def status(
    study: Annotated[str, Parameter(help="YAML file of the study, or a preset: first, paper, best.")],
    *,
    out: OutFlag = None,
    output: Output = Output(),
) -> None:
    """Show the progress of a study: finished, running, broken and failed artefacts; remaining time.

    Files are counted but not opened; `palpate study store check` reads them. The time is the sum of expected costs.
    """
    from palpate.study import find_status, read_study

    chosen = read_study(study)
    folder = out or Path("results") / chosen.name
    if not (folder / "store").is_dir():
        raise PalpateError(
            f"{folder} contains no artefacts of a study.",
            "Give the study's result folder by --out.",
            code="study-folder-empty",
        )
    found = find_status(chosen, folder)
    facts = _describe(found, folder)
    rows = [part | {"kind": kind} for kind, part in facts["kinds"].items()]
    failures = (f"failed in the last run: {failure.task}: {failure.reason}" for failure in found.failures)
    output.show(facts, Report(chosen.name, _COLUMNS, rows), *failures)


def _describe(found: StudyStatus, folder: Path) -> dict[str, Any]:
    return {
        "out": str(folder),
        "kinds": {kind: asdict(part) for kind, part in found.kinds.items()},
        "made": sum(part.made for part in found.kinds.values()),
        "of": sum(part.total for part in found.kinds.values()),
        "remaining_s": sum(part.remaining_s for part in found.kinds.values()),
        "failures": [asdict(failure) for failure in found.failures],
    }
