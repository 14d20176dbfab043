"""`palpate status`: how far a study is."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.cli.flag import JsonFlag
from palpate.cli.output import print_json, print_table
from palpate.core import PalpateError

if TYPE_CHECKING:
    from palpate.study import StudyStatus

COLUMNS = ["artefact", "made", "of", "at work", "quarantined", "left, s on one core"]


def status(
    study: Annotated[str, Parameter(help="YAML file of the study, or a preset: first, paper, best.")],
    *,
    out: Annotated[Path | None, Parameter(help="Its result folder; without it, results/NAME.")] = None,
    json: JsonFlag = False,
) -> None:
    """Say how far a study is: what is made, at work, broken or failed, and the time that is left.

    Files are counted, not opened; `palpate store check` reads them. The time is from expected costs.
    """
    from palpate.study import find_status, read_study

    chosen = read_study(study)
    folder = out or Path("results") / chosen.name
    if not (folder / "store").is_dir():
        raise PalpateError(
            f"{folder} holds no artefacts of a study.",
            "Give its result folder with --out.",
            code="study-folder-empty",
        )
    found = find_status(chosen, folder)
    if json:
        print_json(_describe(found, folder))
    else:
        _print(found, chosen.name)


def _describe(found: StudyStatus, folder: Path) -> dict[str, Any]:
    return {
        "out": str(folder),
        "kinds": {kind: asdict(part) for kind, part in found.kinds.items()},
        "made": sum(part.made for part in found.kinds.values()),
        "of": sum(part.total for part in found.kinds.values()),
        "remaining_s": sum(part.remaining_s for part in found.kinds.values()),
        "failures": [asdict(failure) for failure in found.failures],
    }


def _print(found: StudyStatus, name: str) -> None:
    rows = [
        [kind, str(part.made), str(part.total), str(part.working), str(part.quarantined), f"{part.remaining_s:.0f}"]
        for kind, part in found.kinds.items()
    ]
    print_table(name, COLUMNS, rows)
    for failure in found.failures:
        print(f"failed in the last run: {failure.task}: {failure.reason}")
