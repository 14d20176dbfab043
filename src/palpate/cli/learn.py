"""`palpate recording train`: train estimators on a recording of any sensor with markers and its poses."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from palpate.cli.border import keep_results
from palpate.cli.flag import flags_of
from palpate.cli.output import Output, check_folder
from palpate.cli.progress import show_progress
from palpate.core import ArtefactStore, PalpateError, wrap_write_errors
from palpate.core.report import page_markdown, plain_page
from palpate.datasets import ColumnMapping
from palpate.learn import RecordingSpec

if TYPE_CHECKING:
    from palpate.learn import RecordingResult

_RECORDING = (
    "Table of poses (.csv, .jsonl) beside its images or video, an HDF5 file, or a folder that holds one of these or "
    "is a LeRobot dataset."
)
_OUT = "Folder for the model (model.h5), the report and what an interrupted run needs to go on."
_LEARN = (
    "Columns to learn, with commas between, each by what it is where its name does not tell "
    "(pose_4=rx_deg,pose_3=depth_mm); without it, rx, ry and depth where there are such, else all."
)
_IMAGE = "Column that names or numbers images, where its name does not tell."
_PRESS = "Column that says to which press an image belongs; without one each image is its own press."
_ANGLES = "Unit of angles whose column names none."
_LENGTHS = "Unit of lengths whose column names none."
_EULER = (
    "Order of Euler angles rx, ry, rz, small letters about fixed axes, capitals about turned ones (xyz, ZYX); they "
    "become the rotation vector of the tilt. Without it, angles are learnt as they stand."
)
_REST = "Image of the untouched sensor, where the table has none (press or file name 'rest')."
_START = "Model to begin with: of another unit of the same make (model.h5), or of its simulation (.onnx)."


@Parameter(name="*")
@dataclass(frozen=True)
class TableFlags:
    """What the table's columns are, where their names do not tell, and an image at rest."""

    targets: Annotated[str | None, Parameter(help=_LEARN)] = None
    image: Annotated[str | None, Parameter(help=_IMAGE)] = None
    press: Annotated[str | None, Parameter(help=_PRESS)] = None
    angles: Annotated[Literal["deg", "rad"] | None, Parameter(help=_ANGLES)] = None
    lengths: Annotated[Literal["mm", "m"] | None, Parameter(help=_LENGTHS)] = None
    euler: Annotated[str | None, Parameter(help=_EULER)] = None
    rest: Annotated[Path | None, Parameter(help=_REST)] = None

    def choice(self) -> ColumnMapping:
        """These flags as the reader takes them."""
        names = tuple(name.strip() for name in (self.targets or "").split(",") if name.strip())
        return ColumnMapping(
            names, self.image or "", self.press or "", self.angles or "", self.lengths or "", self.euler or ""
        )


def learn(
    recording: Annotated[Path, Parameter(help=_RECORDING)],
    *,
    out: Annotated[Path, Parameter(name=("--out", "-o"), help=_OUT)],
    start: Annotated[Path | None, Parameter(name="--from", help=_START)] = None,
    table: TableFlags = TableFlags(),
    spec: Annotated[RecordingSpec, flags_of(RecordingSpec, group="Learning")] = RecordingSpec(),
    output: Output = Output(),
) -> None:
    """Learn to read a sensor from recorded presses with known poses, and say how well it does on presses held out."""
    from palpate.datasets import read_recording
    from palpate.learn import read_pretrained, recording_page, recording_report, train_on_recording

    check_folder(out)
    begin = read_pretrained(start) if start is not None else None
    found = read_recording(recording, table.choice(), table.rest, spec.max_images, spec.seed)
    for note in found.notes:
        _print_line(note)
    store, first = ArtefactStore(keep_results(out) / "store"), None
    with show_progress(quiet=output.json) as progress:
        if spec.estimators == "all":  # networks on pictures take longest: there is a report before they begin
            fast = spec.model_copy(update={"estimators": "fast"})
            first = train_on_recording(found, fast, store, progress, begin)
            _write(out, first)
        learnt = train_on_recording(found, spec, store, progress, begin, first)
        _write(out, learnt)
    output.show(recording_report(learnt), *plain_page(recording_page(learnt)))


def _write(out: Path, result: RecordingResult) -> None:
    import json

    from palpate.learn import draw_recording_report, recording_page, recording_report, write_model

    write_model(out / "model.h5", result.model)
    draw_recording_report(out, result)
    with wrap_write_errors(out, "Choose another folder."):
        (out / "report.md").write_text(page_markdown(recording_page(result)), encoding="utf-8")
        (out / "report.json").write_text(json.dumps(recording_report(result), indent=2) + "\n", encoding="utf-8")
    _print_line(f"Model: {out / 'model.h5'}. Report: {out / 'report.md'}.")
    try:
        _accept(out, result)
    except PalpateError as error:
        _print_line(f"No acceptance report: {error.problem}")


def _accept(out: Path, result: RecordingResult) -> None:
    """Write the acceptance report of the presses that were held out, where rx, ry and depth were learnt."""
    import numpy as np

    from palpate.design import TILT_SPACE
    from palpate.sensor import AcceptanceSpec, GroundTruth, accept_unit, write_acceptance

    names = result.model.space.names
    if any(name not in names for name in TILT_SPACE.names):
        raise PalpateError(
            f"it judges rx, ry and depth; the model estimates {', '.join(names)}.", code="model-outputs-missing"
        )
    columns = [names.index(name) for name in TILT_SPACE.names]
    seen = result.seen
    judged = seen.split.test
    press = np.unique(seen.press[judged], return_inverse=True)[1].reshape(-1)
    images = tuple(seen.recording.names[row] for row in seen.rows[judged])
    poses = seen.targets[judged][:, columns]
    truth = GroundTruth((), images, press, poses, np.full(len(poses), np.nan))
    accepted = accept_unit(truth, result.estimates[judged][:, columns], None, AcceptanceSpec(zero=False, min_depth=0))
    write_acceptance(out, accepted, f"{seen.recording.name}, presses held out")


def _print_line(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
