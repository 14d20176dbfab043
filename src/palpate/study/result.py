"""Result of a study: one record a design, and the numbers of computed and reused artefacts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from palpate.calibration import PredictedAccuracy
from palpate.design import Design
from palpate.learn import Coverage, ErrorBound, Metrics


@dataclass(frozen=True)
class Counts:
    """Numbers of presses and images of one design.

    Attributes
    ----------
    presses
        Solved presses (one a tilt) that the design's dataset was made from.
    virtual_presses
        Sampled (tilt, azimuth) pairs; the training and validation split is by these.
    samples, validation_samples
        Images of all virtual presses, and the held-out ones among them.
    dropped
        Sampled poses left out, by reason (e.g. ``"wall reached the clamped rim"``).
    """

    presses: int
    virtual_presses: int
    samples: int
    validation_samples: int
    dropped: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True)
class PressSummary:
    """Summary of one solved press.

    Attributes
    ----------
    position, position_column
        Tilt (degrees) or offset (mm) of the obstacle, and its column: ``"tilt_deg"`` or ``"offset_mm"``.
    ended, ended_depth_mm
        Reason of the end, and the wall's depth at that moment (mm).
    force_n, peak_stress_mpa
        Norm of the contact force in the deepest increment (N), and maximum von Mises Cauchy stress (MPa).
    branch
        ``"flat"`` or ``"inverted"`` in the deepest increment.
    displacement_max_mm, displacement_mean_mm
        Maximum and mean displacement of the mesh's nodes in the deepest increment (mm).
    apex_gap_mm
        Distance between the wall and its point of first contact, in the deepest increment (mm).
    azimuth_deg
        Direction of the tilt's axis (degrees); `None` if one press serves every azimuth.
    """

    position: float
    ended: str
    ended_depth_mm: float
    force_n: float
    peak_stress_mpa: float
    branch: str
    displacement_max_mm: float
    displacement_mean_mm: float
    apex_gap_mm: float
    azimuth_deg: float | None = None
    position_column: str = "tilt_deg"


@dataclass(frozen=True)
class DesignResult:
    """Record of one design (skin and marker layout): one row of the grid.

    Attributes
    ----------
    design
        Skin, markers, camera and elastomer.
    clean, jittered
        Errors on the held-out presses without and with pixel jitter; `None` for a failed design (`failure`).
    travel_mm
        Distance in space of a marker from rest at the maximum depth, mean over markers and sampled poses (mm).
    force_n
        Norm of the contact force in the deepest increment of the press of minimum tilt (N).
    peak_stress_mpa
        Maximum von Mises Cauchy stress in any increment of any press (MPa).
    bistable_from_mm
        Depth from which the skin has a second, inverted state at the minimum tilt (mm); nan if none was found. A
        design that works deeper can show two images at one pose.
    presses
        All presses of the design, by ascending tilt.
    counts
        Numbers of presses, samples and poses left out; `None` if the design failed before the dataset.
    seed
        Seed of the study.
    versions
        Versions of palpate, of its stages and of the libraries that matter.
    artefacts
        Keys of the artefacts in the store, by kind: ``press``, ``dataset``, ``limit``, ``estimator``, ``learning``.
    bounds
        Bounds on the error of any estimator, by depth; empty if the design failed before.
    coverage
        Coverage of the estimator's intervals on presses that neither trained nor calibrated; `None` without
        intervals, as with too few presses to calibrate on.
    repeat_rmse_deg
        Clean RMSE of the angle of every single training (degrees); may be empty.
    spec
        Settings of press, camera, dataset and learning, as JSON data by stage, with seeds.
    built
        Predicted accuracy of built units, before and after calibration presses; may be empty.
    failure
        Reason for a missing result or prediction; empty otherwise.
    """

    design: Design
    clean: Metrics | None
    jittered: Metrics | None
    travel_mm: float
    force_n: float
    peak_stress_mpa: float
    bistable_from_mm: float
    presses: tuple[PressSummary, ...]
    counts: Counts | None
    seed: int
    versions: Mapping[str, str]
    artefacts: Mapping[str, tuple[str, ...]]
    bounds: tuple[ErrorBound, ...] = ()
    coverage: Coverage | None = None
    repeat_rmse_deg: tuple[float, ...] = ()
    spec: Mapping[str, Any] = field(default_factory=dict)
    built: tuple[PredictedAccuracy, ...] = ()
    failure: str = ""


@dataclass(frozen=True)
class DesignBounds:
    """Error bounds of one design.

    Attributes
    ----------
    design
        Skin, markers, camera and elastomer.
    limits
        Bounds by ascending depth.
    failure
        Reason for missing bounds; empty otherwise.
    """

    design: Design
    limits: tuple[ErrorBound, ...]
    failure: str = ""


@dataclass(frozen=True)
class TaskFailure:
    """Failed task of a study: its name and the reason in one sentence."""

    task: str
    reason: str


@dataclass(frozen=True)
class StudyResult:
    """All designs of a study, with failures and counts.

    Attributes
    ----------
    name
        Name of the study.
    designs
        One record a design, in the order of the study.
    failures
        Tasks that failed, with their reasons.
    computed, reused
        Numbers of artefacts made in this run and found in the store, by kind.
    wall_s
        Wall-clock time of this run (s).
    """

    name: str
    designs: tuple[DesignResult, ...]
    failures: tuple[TaskFailure, ...]
    computed: Mapping[str, int]
    reused: Mapping[str, int]
    wall_s: float
