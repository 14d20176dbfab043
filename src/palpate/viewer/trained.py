"""What `palpate recording train` left in a folder: a model, and the data and pictures of its report."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from palpate.core import PalpateError
from palpate.learn import RecordedModel, is_recorded_model, read_model

MODEL = "model.h5"
_AGAIN = "Make it again by palpate recording train."
PICTURES = {
    "correspondence.png": "Dots of six images, with their ways from rest",
    "errors.png": "Errors over the truth, and over the presses that taught",
}
"""Pictures of a report, and what they show."""


@dataclass(frozen=True, eq=False)
class TrainedSensor:
    """A folder of `palpate recording train`.

    Attributes
    ----------
    folder
        It.
    model
        What reads images.
    report
        Data of the report, as `palpate.learn.recording_report` gives them.
    """

    folder: Path
    model: RecordedModel
    report: dict[str, Any]

    @property
    def pictures(self) -> dict[str, Path]:
        """Files of the pictures that are there, by name."""
        return {name: self.folder / name for name in PICTURES if (self.folder / name).is_file()}


def is_trained_sensor(folder: Path) -> bool:
    """Whether a folder holds a model that was learnt from a recording."""
    return (folder / MODEL).is_file() and is_recorded_model(folder / MODEL)


def read_trained_sensor(folder: Path) -> TrainedSensor:
    """Read what `palpate recording train` left.

    Raises
    ------
    PalpateError
        If model or report cannot be read.
    """
    model, path = read_model(folder / MODEL), folder / "report.json"
    try:
        report = json.loads(path.read_text("utf-8"))
    except (OSError, ValueError) as error:
        raise PalpateError(f"{path} cannot be read: {error}.", _AGAIN, code="file-unreadable") from error
    if not isinstance(report, dict) or not isinstance(report.get("estimators"), list):
        raise PalpateError(f"{path} is no report of palpate recording train.", _AGAIN, code="report-unreadable")
    return TrainedSensor(folder, model, report)


def error_columns(sensor: TrainedSensor) -> list[str]:
    """Heads of the table of errors."""
    names = [axis if unit == "1" else f"{axis}, {unit}" for axis, unit, _ in sensor.model.outputs]
    return ["estimator", "images read", *(f"{name}: RMSE" for name in names), *(f"{name}: most" for name in names)]


def error_rows(sensor: TrainedSensor) -> list[list[str]]:
    """The table of errors on held-out presses, an estimator a row; the one that is kept first.

    Raises
    ------
    PalpateError
        If the report lacks what a row needs.
    """
    axes = [axis for axis, _, _ in sensor.model.outputs]
    try:
        found = sorted(sensor.report["estimators"], key=lambda one: one["name"] != sensor.report["best"])
        return [
            [
                one["name"],
                f"{one['share_of_images']:.0%}",
                *(f"{one['errors'][axis]['rmse']:.3g}" for axis in axes),
                *(f"{one['errors'][axis]['max']:.3g}" for axis in axes),
            ]
            for one in found
        ]
    except (KeyError, TypeError, ValueError) as error:
        raise PalpateError(
            f"The report in {sensor.folder} lacks {error}.", _AGAIN, code="report-incomplete"
        ) from error
