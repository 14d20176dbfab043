"""`palpate calibration accept`: acceptance test of a built unit on recorded presses of known angles."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.camera import read_image
from palpate.cli.border import OUTSIDE
from palpate.cli.column_flags import ColumnFlags
from palpate.cli.flag import flags_of
from palpate.cli.output import Output, check_folder
from palpate.cli.unit import ModelFlags, UnitFlags, open_printing_scale
from palpate.core import BoolArray, FloatArray, PalpateError
from palpate.core.report import plain_page
from palpate.design import TILT_SPACE
from palpate.sensor import AcceptanceSpec

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from palpate.learn import Predictor, RecordedModel
    from palpate.sensor import GroundTruth, Unit
    from palpate.surrogate import Twin


_TRUTH = (
    "Table of the ground truth: columns image, press, rx_deg, ry_deg, depth_mm; in the folder of its images. "
    "Images of the unloaded skin have the press 'rest'."
)
_READINGS = "Readings of these images by `palpate sensor live --out`; the images are then not evaluated again."
_OUT = "Folder for the report: accept.pdf, accept.md, accept.json."
_NAME = "Name of the unit in the report."


@Parameter(name="*")
@dataclass(frozen=True)
class EstimatorFlags:
    """Estimator of the images, or readings of them, and columns of the ground truth."""

    reads: ModelFlags = ModelFlags()
    readings: Annotated[Path | None, Parameter(help=_READINGS)] = None
    columns: ColumnFlags = ColumnFlags()


@Parameter(name="*")
@dataclass(frozen=True)
class ReportFlags:
    """Name and folder of the report."""

    name: Annotated[str, Parameter(help=_NAME)] = "unit"
    out: Annotated[Path | None, Parameter(name=("--out", "-o"), help=_OUT)] = None


def accept(
    truth: Annotated[Path, Parameter(help=_TRUTH)],
    *,
    estimator: EstimatorFlags = EstimatorFlags(),
    built: UnitFlags = UnitFlags(),
    wanted: Annotated[AcceptanceSpec, flags_of(AcceptanceSpec, group="Tolerances")] = AcceptanceSpec(),
    report: ReportFlags = ReportFlags(),
    output: Output = Output(),
) -> int:
    """Test a unit's pose errors on presses of known angles against the tolerances."""
    from palpate.learn import is_recorded_model, read_model
    from palpate.sensor import (
        accept_unit,
        acceptance_page,
        open_model,
        read_ground_truth,
        read_readings,
        write_acceptance,
    )

    if estimator.reads.model is not None and estimator.readings is not None:
        raise PalpateError(
            "--model and --readings exclude each other.",
            "Give one of them, or neither.",
            code="options-exclusive",
        )
    check_folder(report.out)
    known = read_ground_truth(truth, estimator.columns.mapping())
    if estimator.readings is not None:
        estimates, flagged = read_readings(estimator.readings, known)
    else:
        known, model = known.locate(truth.parent), estimator.reads.find(built)
        if is_recorded_model(model):
            estimates, flagged = _read_recorded(known, read_model(model))
        else:
            unit = built.unit()
            estimates, flagged = _read(known, open_model(model, unit.design.skin), unit)
    found = accept_unit(known, estimates, flagged, wanted)
    if report.out is not None:
        write_acceptance(report.out, found, report.name)
        print(f"Report: {report.out / 'accept.pdf'}", file=sys.stderr)
    page = acceptance_page(found, report.name)
    output.show({"unit": report.name, **found.as_dict()}, *plain_page(page))
    return 0 if found.passed else OUTSIDE


def _read(known: GroundTruth, model: Predictor | Twin, unit: Unit) -> tuple[FloatArray, BoolArray]:
    import numpy as np

    from palpate.sensor import check_model, run_sensor

    check_model(model, unit, TILT_SPACE)
    sensor = open_printing_scale([read_image(Path(name)) for name in known.rest], unit, model)
    found = list(run_sensor(sensor, read_images(known.images)))
    poses = np.array([reading.pose for reading in found])
    return poses, np.array([bool(reading.flags) for reading in found])


def _read_recorded(known: GroundTruth, model: RecordedModel) -> tuple[FloatArray, BoolArray]:
    import numpy as np

    from palpate.sensor import run_sensor

    if any(name not in model.space.names for name in TILT_SPACE.names):
        raise PalpateError(
            f"Acceptance tests rx, ry and depth; the model estimates {', '.join(model.space.names)}.",
            "Train a model of all three: palpate recording train --targets.",
            code="model-outputs-missing",
        )
    found = list(run_sensor(model, read_images(known.images)))
    poses = np.array([[reading[name] for name in TILT_SPACE.names] for reading in found])
    return poses, np.array([bool(reading.flags) for reading in found])


def read_images(names: tuple[str, ...]) -> Iterator[NDArray[Any] | PalpateError]:
    """Yield the images of files; an error stands for one that cannot be read."""
    for name in names:
        try:
            yield read_image(Path(name))
        except PalpateError as error:
            yield error
