"""Readings of one unit's images with their ground truth: a table of numbers, stored as JSON."""

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
"""Measurands: pose, force along the wall's normal, 1/µ. The last two are NaN for a network."""
COLUMNS = (
    "press",
    "flagged",
    "latency_ms",
    *MEASURANDS,
    *(f"{n}_read" for n in MEASURANDS),
    *(f"{n}_half" for n in MEASURANDS),
)
"""Columns of the table of images: ground truth, readings, and half-widths of 90 % intervals."""


class ParameterEstimate(NamedTuple):
    """Unit parameter estimated by calibration presses.

    Attributes
    ----------
    name
        As in `palpate.calibration.IdentificationResult.rows`.
    truth
        True value.
    mean, sd
        Posterior mean and standard deviation.
    prior_sd
        Prior standard deviation.
    """

    name: str
    truth: float
    mean: float
    sd: float
    prior_sd: float


@dataclass(frozen=True, eq=False)
class UnitTrial:
    """Result of one unit's images.

    Attributes
    ----------
    deviation
        Manufacturing errors.
    images
        (n, 18) by `COLUMNS`; poses in the robot's frame, NaN without a reading. The depth's zero is not corrected.
    zero
        The depth's zero by the first press; `None` if not measured.
    parameters
        Unit parameters estimated by calibration presses; empty without any.
    failure
        Reason of a failed simulation; empty otherwise.
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
        """(n, 3) true rx, ry (degrees) and depth (mm)."""
        return self.column(*POSE)

    @property
    def estimates(self) -> FloatArray:
        """(n, 3) estimated rx, ry (degrees) and depth (mm)."""
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
        """Return the trial with its poses replaced by the ground truth."""
        images = self.images.copy()
        images[:, [COLUMNS.index(f"{name}_read") for name in POSE]] = self.truth
        return replace(self, images=images, zero=None)

    def corrected(self) -> FloatArray:
        """Estimates with their depth on the robot's scale, if the zero was found."""
        return self.estimates + np.array([0.0, 0.0, self.zero.offset if self.zero else 0.0])


def write_trial(path: Path, trial: UnitTrial) -> None:
    """Write the result of a unit; non-finite numbers become ``null``."""
    data = {
        "columns": COLUMNS,
        "images": [[value if math.isfinite(value) else None for value in row] for row in trial.images.tolist()],
        "zero": asdict(trial.zero) if trial.zero else None,
        "parameters": [each._asdict() for each in trial.parameters],
        "failure": trial.failure,
    }
    path.write_text(json.dumps(data), encoding="utf-8")


def read_trial(path: Path, deviation: Deviation) -> UnitTrial:
    """Read the result of a unit written by `write_trial`."""
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
    """Compare unit parameters from calibration presses with the truth, at 1/µ = `inverse_friction`."""
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
    """Truth, error and half-width (n,) of one of `MEASURANDS` over the images of some units that have it."""
    rows = np.concatenate([each.column(name, f"{name}_read", f"{name}_half") for each in trials])
    rows = rows[np.isfinite(rows[:, 1])]
    return rows[:, 0], rows[:, 1] - rows[:, 0], rows[:, 2]
