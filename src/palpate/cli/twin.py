"""`palpate twin`: the twins of a study's designs, and how good built units of them will be."""

from __future__ import annotations

import csv
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.cli.bench import read_tolerance
from palpate.cli.flag import JsonFlag
from palpate.cli.output import print_json, print_table
from palpate.cli.progress import Lines
from palpate.cli.run import RESULTS, WorkerFlags
from palpate.core import PalpateError, written_whole

if TYPE_CHECKING:
    from palpate.study import BuiltDesign

_SOURCE = "YAML file of a study, or a preset: first, paper, best."
_OUT = "Result folder; without it, results/NAME. Twins go to its folder twins."
_KNOWN = "Known presses of each unit in the second half of the table; without it, as the study says, or 5."
_TOLERANCE = "Tolerances as NAME=VALUE, as for `palpate bench`."
_COLUMNS = ("height_mm", "thickness_mm", "markers", "known", "rmse_deg", "worst_deg", "depth_rmse_mm", "noise_deg")


def twin(
    source: Annotated[str, Parameter(help=_SOURCE)],
    *,
    out: Annotated[Path | None, Parameter(name=("--out", "-o"), help=_OUT)] = None,
    hands: WorkerFlags = WorkerFlags(),
    tolerance: Annotated[tuple[str, ...], Parameter(help=_TOLERANCE, negative="", consume_multiple=True)] = (),
    known: Annotated[int | None, Parameter(help=_KNOWN)] = None,
    json: JsonFlag = False,
) -> int:
    """Make the twin of every skin of a study, and foresee the errors of built units of every design.

    Each skin is pressed at every tilt of the study under seven frictions; nothing is trained. What an earlier run
    left in the result folder is used.
    """
    from palpate.study import BuiltSpec, read_study, run_twins

    if known is not None and not 1 <= known <= 100:
        raise PalpateError(f"--known is {known}.", "Give 1 to 100 known presses.")
    hands.check()
    if hands.cluster is not None:
        raise PalpateError("Twins are made on this machine.", "Give --workers instead of --cluster.")
    study = read_study(source)
    folder = out or RESULTS / study.name
    asked = study.built or BuiltSpec()
    chosen = {"known": known or asked.known, "tolerance": read_tolerance(tolerance) if tolerance else asked.tolerance}
    study = study.model_copy(update={"built": asked.model_copy(update=chosen)})
    found = run_twins(study, folder, hands.workers, Lines())
    rows = [row for design in found for row in _rows(design)]
    _keep(folder / "twins", found, rows)
    if json:
        print_json({"out": str(folder / "twins"), "designs": rows})
    else:
        print_table(
            f"{study.name}: built units", list(_COLUMNS), [[_text(row[name]) for name in _COLUMNS] for row in rows]
        )
        print(
            "rmse_deg: rx and ry of all units; worst_deg: greatest error that 19 of 20 units stay below; known: "
            f"presses by which each unit was identified. Twins: {folder / 'twins'}"
        )
    failed = [design for design in found if design.problem]
    for design in failed:
        print(f"{design.skin.build().name}, {design.markers.count} markers: {design.problem}", file=sys.stderr)
    return 1 if failed else 0


def _rows(design: BuiltDesign) -> list[dict[str, Any]]:
    return [
        {
            "height_mm": design.skin.height,
            "thickness_mm": design.skin.thickness,
            "markers": design.markers.count,
            "known": figure.known,
            "rmse_deg": round(figure.rmse_deg, 4),
            "worst_deg": round(figure.worst_deg, 4),
            "depth_rmse_mm": round(figure.depth_rmse, 4),
            "noise_deg": round(figure.noise_deg, 4),
        }
        for figure in design.figures
    ]


def _keep(folder: Path, designs: tuple[BuiltDesign, ...], rows: list[dict[str, Any]]) -> None:
    """The twins under names that people read, and the table."""
    from palpate.study import keep_twins

    folder.mkdir(parents=True, exist_ok=True)
    keep_twins(folder.parent, ((design.skin, design.twin) for design in designs if design.twin is not None))
    with written_whole(folder / "built.csv") as draft, draft.open("w", newline="") as file:
        table = csv.DictWriter(file, _COLUMNS, lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


def _text(value: Any) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
