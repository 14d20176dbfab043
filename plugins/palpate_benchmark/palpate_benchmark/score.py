"""Scores of predictions: errors over all images and by unit, design, friction, depth and branch.

Errors of rx and ry are pooled as the angle. The 95th percentile is the smallest error that at least 95 % of them do
not exceed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import numpy as np

from palpate.core import BoolArray, FloatArray, PalpateError
from palpate_benchmark.predictions import FORCE, POSE, Predictions, half_width_column, read_predictions
from palpate_benchmark.read_set import BenchmarkSet, SplitTable
from palpate_benchmark.unit_images import LABELS

Track = Literal["markers", "pictures"]
FRICTIONS = (0.0, 0.5, 1.0, np.inf)
"""Limits of the friction coefficient between groups of images."""
_NINETEEN = 0.95
_PARTS = {"angle": POSE[:2], "depth": POSE[2:], "force": (FORCE,)}
"""Quantities that are scored, with the columns that are pooled for each."""


@dataclass(frozen=True)
class ErrorLine:
    """Errors of one quantity over some images.

    Attributes
    ----------
    rmse, max, p95
        Root mean square, maximum and 95th percentile; degrees, mm or N.
    coverage, half_width
        Share of true values in the given intervals, and their mean half-width; NaN without intervals.
    """

    rmse: float
    max: float
    p95: float
    coverage: float
    half_width: float


@dataclass(frozen=True)
class ScoreLine:
    """Errors over one group of images.

    Attributes
    ----------
    by, name
        Property that the images share (``all``, ``design``, ``unit``, ``friction``, ``depth_mm`` or ``branch``), and
        its value.
    images
        Number of images.
    parts
        Errors of ``angle`` (degrees), ``depth`` (mm) and, if predicted, ``force`` (N).
    """

    by: str
    name: str
    images: int
    parts: Mapping[str, ErrorLine]

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)


@dataclass(frozen=True)
class BenchmarkScore:
    """Scores of a table of predictions.

    Attributes
    ----------
    track
        Images that were scored.
    lines
        Errors by group; the first group is all images.
    """

    track: Track
    lines: tuple[ScoreLine, ...]

    @property
    def all(self) -> ScoreLine:
        """Errors over all images."""
        return self.lines[0]

    @property
    def worst_unit_p95_deg(self) -> float:
        """Maximum over units of the 95th percentile of the unit's angle errors, degrees."""
        return max(line.parts["angle"].p95 for line in self.lines if line.by == "unit")

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        lines = [line.as_dict() for line in self.lines]
        return {"track": self.track, "worst_unit_p95_deg": self.worst_unit_p95_deg, "lines": lines}


def score_file(benchmark: BenchmarkSet, path: Path, track: Track = "markers") -> BenchmarkScore:
    """Score a table of predictions; see `score_predictions`."""
    return score_predictions(benchmark, read_predictions(path), track)


def score_predictions(benchmark: BenchmarkSet, predictions: Predictions, track: Track = "markers") -> BenchmarkScore:
    """Score predictions of the test.

    Parameters
    ----------
    benchmark
        Data set with its hidden labels.
    predictions
        One prediction of each image of the track.
    track
        All images of the test (``markers``), or the rendered ones (``pictures``).

    Raises
    ------
    PalpateError
        If images are missing, repeated or unknown, or the labels cannot be read.
    """
    truth = select_track(benchmark.table("test"), track)
    found = predictions.rows(truth.image, f"the track {track}")
    columns = {name: truth.labels[:, LABELS.index(name)] for name in (*POSE, FORCE)}
    errors = {name: found.values[name] - columns[name] for name in columns if name in found.values}
    halves = {
        name: found.values[half_width_column(name)] for name in errors if half_width_column(name) in found.values
    }
    lines = []
    for by, name, rows in _groups(truth):
        parts = {
            part: _line([errors[one][rows] for one in names], [halves[one][rows] for one in names if one in halves])
            for part, names in _PARTS.items()
            if all(one in errors for one in names)
        }
        lines.append(ScoreLine(by, name, int(rows.sum()), parts))
    return BenchmarkScore(track, tuple(lines))


def select_track(truth: SplitTable, track: Track) -> SplitTable:
    """Select the rows of a track.

    Raises
    ------
    PalpateError
        If no image is rendered.
    """
    if track == "markers":
        return truth
    rows = truth.picture != ""
    if not rows.any():
        raise PalpateError(
            "The data set has no rendered images.", "Give --track markers.", code="benchmark-no-pictures"
        )
    names = ("image", "unit", "press", "design", "picture", "branch", "labels")
    return SplitTable(**{name: getattr(truth, name)[rows] for name in names})


def _groups(truth: SplitTable) -> Iterator[tuple[str, str, BoolArray]]:
    """Yield groups of images: the property that they share, its value, and a mask (n,)."""
    friction, depth = (truth.labels[:, LABELS.index(name)] for name in ("friction", "depth_mm"))
    yield "all", "all", np.ones(len(truth), bool)
    for design in np.unique(truth.design):
        yield "design", str(design), truth.design == design
    for design in np.unique(truth.design):
        for unit in np.unique(truth.unit[truth.design == design]):
            yield "unit", f"{design} {unit}", (truth.design == design) & (truth.unit == unit)
    for low, high in pairwise(FRICTIONS):
        rows = (friction > low) & (friction <= high)
        if rows.any():
            yield "friction", f"{low:g} to {high:g}", rows
    whole = np.minimum(np.floor(depth), np.ceil(depth.max()) - 1)
    for first in np.unique(whole):
        yield "depth_mm", f"{first:g} to {first + 1:g}", whole == first
    for branch in np.unique(truth.branch):
        yield "branch", str(branch), truth.branch == branch


def _line(errors: list[FloatArray], halves: list[FloatArray]) -> ErrorLine:
    size = np.abs(np.concatenate(errors))
    told = np.concatenate(halves) if len(halves) == len(errors) else None
    return ErrorLine(
        rmse=float(np.sqrt((size**2).mean())),
        max=float(size.max()),
        p95=float(np.quantile(size, _NINETEEN, method="inverted_cdf")),
        coverage=float("nan") if told is None else float((size <= told).mean()),
        half_width=float("nan") if told is None else float(told.mean()),
    )
