"""The judge: how far predictions are off, over all images and by unit, design, friction, depth and state.

Of the angle, rx and ry are pooled. *19 of 20* is the least error that nineteen of twenty values stay below or at.
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
"""Coefficients of friction between which images are judged apart."""
_NINETEEN = 0.95
_PARTS = {"angle": POSE[:2], "depth": POSE[2:], "force": (FORCE,)}
"""What is judged, and the columns that are pooled for it."""


@dataclass(frozen=True)
class ErrorLine:
    """Errors of one quantity over some images.

    Attributes
    ----------
    rmse, max, p95
        Root mean square, greatest, and what 19 of 20 values stay below; degrees, mm or N.
    coverage, half_width
        Share of true values in the given intervals, and their mean half-width; nan without intervals.
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
        What the images have in common: ``all``, ``design``, ``unit``, ``friction``, ``depth_mm`` or ``branch``.
    images
        How many.
    parts
        Errors of ``angle`` (degrees), ``depth`` (mm) and, where it was predicted, ``force`` (N).
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
    """What a table of predictions is worth.

    Attributes
    ----------
    track
        Which images were judged.
    lines
        The first is over all of them.
    """

    track: Track
    lines: tuple[ScoreLine, ...]

    @property
    def all(self) -> ScoreLine:
        """Over all images."""
        return self.lines[0]

    @property
    def worst_unit_p95_deg(self) -> float:
        """Greatest angle, of all units, below which 19 of 20 values of the unit stay, degrees."""
        return max(line.parts["angle"].p95 for line in self.lines if line.by == "unit")

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        lines = [line.as_dict() for line in self.lines]
        return {"track": self.track, "worst_unit_p95_deg": self.worst_unit_p95_deg, "lines": lines}


def score_file(benchmark: BenchmarkSet, path: Path, track: Track = "markers") -> BenchmarkScore:
    """Judge a table of predictions; see `score_predictions`."""
    return score_predictions(benchmark, read_predictions(path), track)


def score_predictions(benchmark: BenchmarkSet, predictions: Predictions, track: Track = "markers") -> BenchmarkScore:
    """Judge predictions of the test.

    Parameters
    ----------
    benchmark
        With its hidden labels.
    predictions
        One of every image of the track.
    track
        All images of the test, or those that have a picture.

    Raises
    ------
    PalpateError
        If images are missing, there twice or unknown, or the labels cannot be read.
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
    """The rows of a track.

    Raises
    ------
    PalpateError
        If no image has a picture.
    """
    if track == "markers":
        return truth
    rows = truth.picture != ""
    if not rows.any():
        raise PalpateError("The set has no pictures.", "Give --track markers.", code="benchmark-no-pictures")
    names = ("image", "unit", "press", "design", "picture", "branch", "labels")
    return SplitTable(**{name: getattr(truth, name)[rows] for name in names})


def _groups(truth: SplitTable) -> Iterator[tuple[str, str, BoolArray]]:
    """Groups of images: what they have in common, by what name, and which they are (n,)."""
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
