"""Made-up records of a study: only for tests."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

import numpy as np

from palpate.design import Design, DomeSpec, MarkerSpec
from palpate.learn import Coverage, ErrorBound, measure_errors
from palpate.study import Counts, DesignResult, PressSummary

if TYPE_CHECKING:
    import pytest  # some environments that read this module have none

LIMITS = (
    ErrorBound(2.4, 48, 1.0, 1.2, 0.2, 0.7, 0.02, 0.3, 0.01),
    ErrorBound(8.0, 48, 1.0, 0.2, 0.1, 0.1, 0.01, 0.05, 0.01),
)


COVERAGE = Coverage(0.9, 120, 3840, 0.905, 0.91, 0.8, 0.1, 0.011, 0.02)


def make_metrics(size, seed=0):
    poses = np.array([[rx, 0.0, depth] for rx in (-5.0, 5.0) for depth in (2.4, 8.0)])
    return measure_errors(poses + size * np.random.default_rng(seed).uniform(-1, 1, poses.shape), poses)


def make_design(height=20.0, thickness=2.0, markers=169, failure=""):
    dome = DomeSpec(height=height, thickness=thickness)
    size = 3.0 / np.sqrt(markers) + 0.1 * thickness + abs(height - 20) / 20
    return DesignResult(
        design=Design(dome, MarkerSpec(count=markers)),
        clean=None if failure else make_metrics(size),
        jittered=None if failure else make_metrics(3 * size, seed=1),
        travel_mm=float("nan") if failure else 1.0 + thickness / (1 + abs(height - 20) / 10),
        force_n=0.4,
        peak_stress_mpa=0.05,
        bistable_from_mm=5.5,
        presses=(
            PressSummary(0.0, "depth reached", 8.0, 0.4, 0.04, "flat", 8.0, 3.1, 0.01),
            PressSummary(12.0, "wall reached the clamped rim", 7.1, 0.3, 0.05, "inverted", 9.0, 4.2, 1.5),
        ),
        counts=None if failure else Counts(2, 60, 460, 92, {"wall reached the clamped rim": 20}),
        seed=3,
        versions={"palpate": "0.1.0", "fea": "1"},
        artefacts={
            "press": ("aa", "bb"),
            "dataset": ("cc",),
            "limit": ("ee",),
            "estimator": ("ff",),
            "learning": ("dd",),
        },
        bounds=LIMITS,
        coverage=None if failure else COVERAGE,
        repeat_rmse_deg=() if failure else (size, size + 0.1, size - 0.1),
        spec={"dataset": {"seed": 4}},
        failure=failure,
    )


FIRST = [make_design(thickness=t, markers=m) for t in (2.0, 3.0) for m in (7, 37, 91, 169)]
PAPER = [
    make_design(height, thickness, markers)
    for height in (10.0, 20.0, 30.0)
    for thickness in (1.0, 2.0, 3.0, 4.0)
    for markers in (7, 37, 91, 169)
]


def leave_out_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let `write_grid` write tables alone, where a test looks at no picture: drawing them takes seconds."""
    monkeypatch.setattr(import_module("palpate.study.grid_io"), "_write_pictures", lambda *_: None)
