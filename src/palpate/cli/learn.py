"""`palpate recording train`: training of estimators on a recording with markers and poses."""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from palpate.cli.border import keep_results
from palpate.cli.column_flags import ColumnFlags
from palpate.cli.flag import flags_of
from palpate.cli.output import RESULTS, Output, check_folder
from palpate.cli.progress import show_progress
from palpate.core import ArtefactStore, PalpateError, wrap_write_errors
from palpate.core.report import page_markdown, plain_page
from palpate.datasets import ColumnMapping
from palpate.learn import RecordingSpec

if TYPE_CHECKING:
    from palpate.learn import PretrainedModel, RecordingResult, SimulatedStart

_RECORDING = (
    "Table of poses (text, JSON lines, Parquet) in the folder of its images or video; an HDF5, NPZ or Zarr file; a "
    "folder with one of these or with HDF5 episodes; a LeRobot dataset; or a ROS bag."
)
_OUT = "Folder for the model (model.h5) and the report. The same command resumes an interrupted run."
_LEARN = (
    "Columns to estimate, separated by commas; COLUMN=QUANTITY if the name does not state the quantity "
    "(pose_4=rx_deg,pose_3=depth_mm). By default rx, ry and depth if they exist, otherwise all columns."
)
_REST = "Image of the unloaded sensor, if the table has no row with the press or file name 'rest'."
_POSE = "Topic of the poses of a ROS bag, if it has several."
_FORCES = (
    "Table of a force/torque sensor with a column of times (text, JSON lines, Parquet). Its forces are interpolated "
    "to the times of the images, which are a column of their table."
)
_TIMES = "Unit of times whose column has no unit in its name."
_FORCE_UNIT = "Unit of forces whose column has no unit in its name; torques are in this unit times m."
_START = (
    "Start of the training: the study of the design (.yaml), whose twin simulates it; the model of another unit of "
    "this design (model.h5); or a network trained on simulated images (.onnx)."
)


@Parameter(name="*")
@dataclass(frozen=True)
class TableFlags:
    """Meaning and units of the table's columns, and a rest image."""

    targets: Annotated[str | None, Parameter(help=_LEARN)] = None
    columns: ColumnFlags = ColumnFlags()
    rest: Annotated[Path | None, Parameter(help=_REST)] = None
    pose: Annotated[str, Parameter(help=_POSE)] = ""
    forces: Annotated[Path | None, Parameter(help=_FORCES)] = None
    times: Annotated[Literal["s", "ms", "us", "ns"] | None, Parameter(help=_TIMES)] = None
    force_unit: Annotated[Literal["N", "mN", "kN", "gf", "kgf", "lbf"] | None, Parameter(help=_FORCE_UNIT)] = None

    def mapping(self) -> ColumnMapping:
        """Return the column mapping of these flags, which the reader accepts."""
        if self.forces is None and (unit := self.times or self.force_unit):
            raise PalpateError(
                f"{unit} is a unit of the table --forces, which is missing.",
                "Give --forces FILE, or leave --times and --force-unit out.",
                code="forces-missing",
            )
        return replace(
            self.columns.mapping(self.targets),
            pose=self.pose,
            forces=self.forces,
            times=self.times or "",
            force_unit=self.force_unit or "",
        )


def learn(
    recording: Annotated[Path, Parameter(help=_RECORDING)],
    *,
    out: Annotated[Path, Parameter(name=("--out", "-o"), help=_OUT)],
    start: Annotated[Path | None, Parameter(name="--from", help=_START)] = None,
    table: TableFlags = TableFlags(),
    spec: Annotated[RecordingSpec, flags_of(RecordingSpec, group="Training")] = RecordingSpec(),
    output: Output = Output(),
) -> None:
    """Train estimators on recorded presses with known poses, and report their errors on test presses."""
    from palpate.datasets import read_recording
    from palpate.learn import recording_page, recording_report, train_on_recording

    check_folder(out)
    begin = _read_start(start) if start is not None else None
    found = read_recording(recording, table.mapping(), table.rest, spec.max_images, spec.seed)
    for note in found.notes:
        _print_line(note)
    store, first = ArtefactStore(keep_results(out) / "store"), None
    with show_progress(quiet=output.json) as progress:
        if spec.estimators == "all":  # image networks take longest: a report is written before they begin
            fast = spec.model_copy(update={"estimators": "fast"})
            first = train_on_recording(found, fast, store, progress, begin)
            _write(out, first)
        learnt = train_on_recording(found, spec, store, progress, begin, first)
        _write(out, learnt)
    output.show(recording_report(learnt), *plain_page(recording_page(learnt)))


def _read_start(path: Path) -> PretrainedModel | SimulatedStart:
    """Read a model, or a study of one design and its twin."""
    from palpate.learn import SimulatedStart, read_pretrained
    from palpate.study import read_study
    from palpate.surrogate import find_twin, read_twin

    if path.suffix.lower() not in (".yaml", ".yml"):
        return read_pretrained(path)
    study = read_study(path)
    skins, layouts = list(study.designs.skins()), study.designs.markers
    if len(skins) * len(layouts) != 1:
        raise PalpateError(
            f"{path} has {len(skins) * len(layouts)} designs, and a training starts from one.",
            "Give a study of the recorded sensor's design alone.",
            code="start-designs",
        )
    design = study.design(skins[0], layouts[0])
    found = find_twin(RESULTS, design.skin, design.material, lambda error: _print_line(f"Skipped: {error.problem}"))
    if found is None:
        raise PalpateError(
            f"No twin of {design.skin.name} with the material of {path} was found in {RESULTS}/*/twins.",
            f"Make it once: palpate calibration predict {path}",
            code="start-twin-missing",
        )
    _print_line(f"Start: the twin {found}.")
    return SimulatedStart(path.name, design, read_twin(found))


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
    """Write the acceptance report of the test presses, if the model estimates rx, ry and depth."""
    import numpy as np

    from palpate.design import TILT_SPACE
    from palpate.sensor import AcceptanceSpec, Certificate, GroundTruth, accept_unit

    names = result.model.space.names
    if any(name not in names for name in TILT_SPACE.names):
        raise PalpateError(
            f"it tests rx, ry and depth; the model estimates {', '.join(names)}.", code="model-outputs-missing"
        )
    columns = [names.index(name) for name in TILT_SPACE.names]
    seen = result.seen
    judged = seen.split.test
    press = np.unique(seen.press[judged], return_inverse=True)[1].reshape(-1)
    images = tuple(seen.recording.names[row] for row in seen.rows[judged])
    poses = seen.targets[judged][:, columns]
    truth = GroundTruth((), images, press, poses, np.full(len(poses), np.nan))
    accepted = accept_unit(truth, result.estimates[judged][:, columns], None, AcceptanceSpec(zero=False, min_depth=0))
    Certificate(accepted, f"{seen.recording.name}, test presses").write(out)


def _print_line(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
