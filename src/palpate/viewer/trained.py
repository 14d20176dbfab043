"""Result of `palpate recording train` in a folder: a model, and data and figures of its report."""

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
    "correspondence.png": "Markers of six images, with their displacements",
    "errors.png": "Errors by true value, and by number of training presses",
}
"""Figures of a report, with their captions."""


@dataclass(frozen=True, eq=False)
class TrainedSensor:
    """Folder of `palpate recording train`.

    Attributes
    ----------
    folder
        The folder.
    model
        The estimator of images.
    report
        Data of the report, from `palpate.learn.recording_report`.
    """

    folder: Path
    model: RecordedModel
    report: dict[str, Any]

    @property
    def pictures(self) -> dict[str, Path]:
        """Existing figures by name."""
        return {name: self.folder / name for name in PICTURES if (self.folder / name).is_file()}


def is_trained_sensor(folder: Path) -> bool:
    """Whether a folder contains a model trained on a recording."""
    return (folder / MODEL).is_file() and is_recorded_model(folder / MODEL)


def read_trained_sensor(folder: Path) -> TrainedSensor:
    """Read the result of `palpate recording train`.

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
    """Headings of the table of errors."""
    symbols = {"deg": " (°)", "1": ""}
    names = [f"{axis}{symbols.get(unit, f' ({unit})')}" for axis, unit, _ in sensor.model.outputs]
    return ["estimator", "images read", *(f"RMSE {name}" for name in names), *(f"maximum {name}" for name in names)]


def error_rows(sensor: TrainedSensor) -> list[list[str]]:
    """Table of errors on held-out presses, an estimator a row, the selected one first.

    Raises
    ------
    PalpateError
        If the report is incomplete.
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
