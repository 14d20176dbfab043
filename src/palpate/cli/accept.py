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
from palpate.sensor import AcceptanceSpec, ReferenceSpec

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from palpate.learn import RecordedModel
    from palpate.sensor import GroundTruth, Sensor

_TRUTH = (
    "Table of the ground truth: columns image, press, rx_deg, ry_deg, depth_mm; in the folder of its images. "
    "Images of the unloaded skin have the press 'rest'."
)
_READINGS = "Readings of these images by `palpate sensor live --out`; the images are then not evaluated again."
_OUT = "Folder for the certificate: accept.pdf, accept.md, accept.json."
_STUDY = (
    "Table of repeated readings for a gauge repeatability and reproducibility study: columns part, operator, day, "
    "mounting, rx_deg, ry_deg. Only part and angles are required."
)
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
    """Name and folder of the certificate, reference standard and gauge study."""

    name: Annotated[str, Parameter(help=_NAME)] = "unit"
    gauge_study: Annotated[Path | None, Parameter(help=_STUDY)] = None
    reference: Annotated[ReferenceSpec, flags_of(ReferenceSpec, group="Reference and environment")] = ReferenceSpec()
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
    from palpate.sensor import Certificate, GaugeStudy, accept_unit, read_ground_truth, read_readings

    if estimator.reads.model is not None and estimator.readings is not None:
        raise PalpateError(
            "--model and --readings exclude each other.",
            "Give one of them, or neither.",
            code="options-exclusive",
        )
    if not report.name.strip():
        raise PalpateError(
            f"The name of the unit is '{report.name}'.", "Give --name, such as its number.", code="name-empty"
        )
    check_folder(report.out)
    study = GaugeStudy.read(report.gauge_study) if report.gauge_study else None
    files: dict[str, list[Path | None]] = {
        "recording": [truth],
        "gauge study": [report.gauge_study],
        "lens": [built.lens],
        "unit": [built.unit_file],
    }
    known, sensor = read_ground_truth(truth, estimator.columns.mapping()), None
    if estimator.readings is not None:
        files["readings"] = [estimator.readings]
        estimates, flagged = read_readings(estimator.readings, known)
    else:
        known, model = known.locate(truth.parent), estimator.reads.find(built)
        files |= {"estimator": [model], "images": [Path(name) for name in (*known.rest, *known.images)]}
        estimates, flagged, sensor = _read(known, model, built)
    found = accept_unit(known, estimates, flagged, wanted, report.reference)
    inputs = _hash(files)
    if sensor is not None:
        inputs["design"] = f"{sensor.unit.design.skin.name}, {len(sensor.unit.design.layout)} markers"
    fitter = sensor.estimator.twin_fit if sensor else None
    certificate = Certificate(found, report.name, inputs, found.budget(fitter) if fitter else None, study)
    if report.out is not None:
        certificate.write(report.out)
        print(f"Certificate: {report.out / 'accept.pdf'}", file=sys.stderr)
    output.show(certificate.as_dict(), *plain_page(certificate.page()))
    return 0 if found.passed else OUTSIDE


def _hash(files: dict[str, list[Path | None]]) -> dict[str, str]:
    """Describe files by name and the SHA-256 hash of their concatenated contents."""
    import hashlib

    found = {}
    for name, paths in files.items():
        digest, given = hashlib.sha256(), [path for path in paths if path is not None]
        for path in given:
            digest.update(path.read_bytes() if path.is_file() else b"")
        if given:
            label = given[0].name if len(given) == 1 else f"{len(given)} files"
            found[name] = f"{label}, SHA-256 {digest.hexdigest()}" if given[0].is_file() else f"{label}, a folder"
    return found


def _read(known: GroundTruth, path: Path, built: UnitFlags) -> tuple[FloatArray, BoolArray, Sensor | None]:
    """Read images by the model in a file; a model that was trained on a recording has no sensor."""
    import numpy as np

    from palpate.learn import is_recorded_model, read_model
    from palpate.sensor import check_model, open_model, run_sensor

    reader: RecordedModel | Sensor
    sensor = None
    if is_recorded_model(path):
        reader = model = read_model(path)
        if any(name not in model.space.names for name in TILT_SPACE.names):
            raise PalpateError(
                f"Acceptance tests rx, ry and depth; the model estimates {', '.join(model.space.names)}.",
                "Train a model of all three: palpate recording train --targets.",
                code="model-outputs-missing",
            )
    else:
        unit = built.unit()
        estimator = open_model(path, unit.design.skin)
        check_model(estimator, unit, TILT_SPACE)
        reader = sensor = open_printing_scale([read_image(Path(name)) for name in known.rest], unit, estimator)
    found = list(run_sensor(reader, read_images(known.images)))
    poses = np.array([[reading[name] for name in TILT_SPACE.names] for reading in found])
    return poses, np.array([bool(reading.flags) for reading in found]), sensor


def read_images(names: tuple[str, ...]) -> Iterator[NDArray[Any] | PalpateError]:
    """Yield the images of files; an error stands for one that cannot be read."""
    for name in names:
        try:
            yield read_image(Path(name))
        except PalpateError as error:
            yield error
