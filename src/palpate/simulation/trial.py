"""What one unit's images gave, beside the truth: a table of numbers, kept as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from palpate.calibration import Deviation, IdentificationResult, ToleranceSpec
from palpate.core import BoolArray, FloatArray, IntArray
from palpate.sensor import DepthZero

POSE = ("rx_deg", "ry_deg", "depth_mm")
MEASURANDS = (*POSE, "force_n", "inverse_friction")
"""What an image tells: pose, force along the wall's normal, 1/µ. The last two are NaN where a network reads."""
COLUMNS = (
    "press",
    "flagged",
    "latency_ms",
    *MEASURANDS,
    *(f"{n}_read" for n in MEASURANDS),
    *(f"{n}_half" for n in MEASURANDS),
)
"""Columns of the table of images: the truth of what is told, what was read, and half-widths of its 90 % intervals."""


class ParameterEstimate(NamedTuple):
    """One number of a unit that known presses told.

    Attributes
    ----------
    name
        As in `palpate.calibration.IdentificationResult.rows`.
    truth
        What it is.
    mean, sd
        What was told.
    prior_sd
        Standard deviation before any press.
    """

    name: str
    truth: float
    mean: float
    sd: float
    prior_sd: float


@dataclass(frozen=True, eq=False)
class UnitTrial:
    """What one unit's images gave.

    Attributes
    ----------
    deviation
        What was not as designed.
    images
        (n, 18) by `COLUMNS`; poses in the robot's frame, NaN where the sensor told nothing. The depth's zero is not
        taken out.
    zero
        The depth's zero by the first press; `None` where it was not asked for.
    parameters
        What known presses told of the unit; empty without any.
    failure
        Why the unit could not be played; empty where it was.
    """

    deviation: Deviation
    images: FloatArray
    zero: DepthZero | None = None
    parameters: tuple[ParameterEstimate, ...] = ()
    failure: str = ""

    def column(self, *names: str) -> FloatArray:
        """Columns (n, len(names)) by their names."""
        return self.images[:, [COLUMNS.index(name) for name in names]]

    @property
    def truth(self) -> FloatArray:
        """(n, 3) rx, ry (degrees) and depth (mm)."""
        return self.column(*POSE)

    @property
    def estimates(self) -> FloatArray:
        """(n, 3) the same as read."""
        return self.column(*(f"{name}_read" for name in POSE))

    @property
    def press(self) -> IntArray:
        """(n,) number of the press."""
        return self.column("press")[:, 0].astype(int)

    @property
    def flagged(self) -> BoolArray:
        """(n,) whether the reading had a flag."""
        return self.column("flagged")[:, 0] > 0

    @property
    def latency_ms(self) -> FloatArray:
        """(n,) from image to pose."""
        return self.column("latency_ms")[:, 0]

    def with_exact_poses(self) -> UnitTrial:
        """The same images, as if their poses had been read without an error."""
        images = self.images.copy()
        images[:, [COLUMNS.index(f"{name}_read") for name in POSE]] = self.truth
        return replace(self, images=images, zero=None)

    def corrected(self) -> FloatArray:
        """Estimates with their depth on the robot's scale, if the zero was found."""
        return self.estimates + np.array([0.0, 0.0, self.zero.offset if self.zero else 0.0])


def write_trial(path: Path, trial: UnitTrial) -> None:
    """Write what a unit gave; what is not a number becomes ``null``."""
    data = {
        "columns": COLUMNS,
        "images": [[value if math.isfinite(value) else None for value in row] for row in trial.images.tolist()],
        "zero": asdict(trial.zero) if trial.zero else None,
        "parameters": [each._asdict() for each in trial.parameters],
        "failure": trial.failure,
    }
    path.write_text(json.dumps(data), encoding="utf-8")


def read_trial(path: Path, deviation: Deviation) -> UnitTrial:
    """Read what `write_trial` wrote of a unit."""
    data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return UnitTrial(
        deviation=deviation,
        images=np.array(data["images"], float).reshape(-1, len(COLUMNS)),
        zero=DepthZero(**data["zero"]) if data["zero"] else None,
        parameters=tuple(ParameterEstimate(**each) for each in data["parameters"]),
        failure=data["failure"],
    )


def compare_parameters(
    found: IdentificationResult, deviation: Deviation, inverse_friction: float, tolerance: ToleranceSpec
) -> Iterator[ParameterEstimate]:
    """What known presses told of a unit that slips by 1/µ = `inverse_friction`, beside what it is."""
    for row in found.rows(tolerance):
        name = row["name"]
        if name.startswith("1/friction"):
            truth = inverse_friction
        elif name == "depth_zero":  # a thicker dome is touched earlier
            truth = deviation.depth_zero - deviation.thickness
        else:
            truth = 1.0 + deviation.modulus if name == "stiffness" else float(getattr(deviation, name))
        yield ParameterEstimate(name, truth, row["mean"], row["sd"], row["before"])


def covered_share(errors: FloatArray, half_widths: FloatArray) -> float:
    """Share of errors within their intervals; NaN without any."""
    known = np.isfinite(errors) & np.isfinite(half_widths)
    return float((np.abs(errors) <= half_widths)[known].mean()) if known.any() else math.nan


def collect_estimates(trials: Sequence[UnitTrial], name: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Truth, error and half-width (n,) of what all images of some units tell by one of `MEASURANDS`, where they
    do."""
    rows = np.concatenate([each.column(name, f"{name}_read", f"{name}_half") for each in trials])
    rows = rows[np.isfinite(rows[:, 1])]
    return rows[:, 0], rows[:, 1] - rows[:, 0], rows[:, 2]
