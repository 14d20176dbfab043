"""What a study leaves behind: one record a design, and a tally of what was computed or found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from palpate.calibration import PredictedAccuracy
from palpate.design import Design
from palpate.learn import Coverage, ErrorBound, Metrics


@dataclass(frozen=True)
class Counts:
    """How much simulated evidence stands behind one design.

    Attributes
    ----------
    presses
        Solved presses (one a tilt) that the design's dataset was made from.
    virtual_presses
        Sampled (tilt, azimuth) pairs; the split into training and validation goes by these.
    samples, validation_samples
        Images over all virtual presses, and those of them held out for validation.
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
    """One solved press in the numbers a table needs.

    Attributes
    ----------
    position, position_column
        Tilt (degrees) or offset (mm) of the obstacle, and its column: ``"tilt_deg"`` or ``"offset_mm"``.
    ended, ended_depth_mm
        Reason of the end, and the wall's depth at that moment (mm).
    force_n, peak_stress_mpa
        Norm of the wall's force in the deepest increment (N), and greatest von Mises Cauchy stress in any (MPa).
    branch
        ``"flat"`` or ``"inverted"`` in the deepest increment.
    displacement_max_mm, displacement_mean_mm
        Greatest and mean displacement of the mesh's nodes in the deepest increment (mm).
    apex_gap_mm
        Distance between the wall and the point that it touched first, in the deepest increment (mm).
    azimuth_deg
        Direction of the tilt's axis (degrees); `None` where one press serves every azimuth.
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
    """One design (dome and marker layout) carried through the whole chain: one row of the grid.

    Attributes
    ----------
    design
        Skin, markers, camera and elastomer.
    clean, jittered
        Errors on the held-out presses without and with pixel jitter; `None` where the chain broke
        (`failure`).
    travel_mm
        Distance in space of a marker from rest at the greatest depth, mean over markers and sampled poses (mm).
    force_n
        Norm of the wall's force in the deepest increment of the straight press, the one of least tilt (N).
    peak_stress_mpa
        Greatest von Mises Cauchy stress in any increment of any press (MPa).
    bistable_from_mm
        Depth from which the dome has a second, inverted state at the least tilt (mm); nan where none was found. A
        design that works deeper can answer one pose by two marker maps.
    presses
        Every press the design stands on, by rising tilt.
    counts
        Numbers of presses, samples and poses left out; `None` where the chain broke before the dataset.
    seed
        Seed of the study.
    versions
        Versions of palpate, of its stages and of the libraries that matter.
    artefacts
        Keys of the artefacts in the store, by kind: ``press``, ``dataset``, ``limit``, ``estimator``, ``learning``.
    bounds
        Bounds on the error of any estimator, by depth; empty where the chain broke before.
    coverage
        What the estimator's intervals are worth on presses that neither trained nor calibrated; `None` where it has
        none, as with too few presses to calibrate on.
    repeat_rmse_deg
        Clean RMSE of the angle of every training by itself (degrees); empty where there is none.
    spec
        What was chosen about press, camera, dataset and learning, as JSON data by stage; seeds among it.
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
    """How good any estimator of one design could be.

    Attributes
    ----------
    design
        Skin, markers, camera and elastomer.
    limits
        Bounds by rising depth.
    failure
        Why there are none; empty where there are.
    """

    design: Design
    limits: tuple[ErrorBound, ...]
    failure: str = ""


@dataclass(frozen=True)
class TaskFailure:
    """One task of a study that gave no artefact: its name and the reason in one sentence."""

    task: str
    reason: str


@dataclass(frozen=True)
class StudyResult:
    """All designs of a study, and how they came about.

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
