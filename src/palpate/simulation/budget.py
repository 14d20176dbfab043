"""Error budget: the change of the readings by each imperfection alone, at its tolerance.

The same poses are read by the nominal unit and by one with a single imperfection; the cost is the difference of the
two errors. Errors of the model, common to both, thus do not hide a small cost.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from palpate.calibration import IMPERFECTIONS, Deviation, Imperfection, ToleranceSpec, single_deviation
from palpate.camera import RenderSpec
from palpate.core import FloatArray, PalpateError, parameters
from palpate.simulation.run_trial import VirtualBench, run_unit_trial
from palpate.simulation.trial import UnitTrial

DRAWS = 2
"""Units of opposite signs and different marker errors, for an imperfection without its own presses.
By hand."""


@dataclass(frozen=True)
class BudgetLine:
    """Cost of one imperfection.

    Attributes
    ----------
    name
        Field of `ToleranceSpec`, or ``images``, ``model`` and ``touch_unknown``.
    label
        Its description.
    tolerance
        Its size, with unit.
    angle_deg, angle_max_deg
        RMS and maximum change of rx and ry.
    depth
        RMS change of the depth, mm.
    units
        Number of simulated units.
    failures
        Reasons of failed units.
    """

    name: str
    label: str
    tolerance: str
    angle_deg: float
    angle_max_deg: float
    depth: float
    units: int
    failures: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)


def run_budget(bench: VirtualBench) -> Iterator[BudgetLine]:
    """Measure line by line; units that are in the store are not simulated again.

    Raises
    ------
    PalpateError
        If the nominal unit cannot be simulated.
    """
    bench.check()
    nominal = run_unit_trial(bench, Deviation())
    clean = run_unit_trial(replace(bench, spec=bench.spec.model_copy(update={"render": RenderSpec()})), Deviation())
    for trial in (nominal, clean):
        if trial.failure:
            raise PalpateError(f"The nominal unit cannot be simulated: {trial.failure}", code="unit-not-simulated")
    yield _line("model", "the model itself, nominal unit, clean images", "", clean.with_exact_poses(), [clean])
    yield _line("images", "light, blur, noise and dirt", "", clean, [nominal])
    for item in IMPERFECTIONS:
        if getattr(bench.spec.tolerance, item.name):
            yield _alone(bench, item, nominal)
    if bench.spec.zero and bench.spec.tolerance.depth_zero:
        touch = next(item for item in IMPERFECTIONS if item.name == "depth_zero")
        blind = replace(bench, spec=bench.spec.model_copy(update={"zero": False}))
        line = _alone(blind, touch, run_unit_trial(blind, Deviation()))
        yield replace(line, name="touch_unknown", label="touch zero, not looked for")


def total(lines: Sequence[BudgetLine]) -> float:
    """Root of the sum of squares of all costs of angle, degrees: all imperfections at their tolerance."""
    return float(np.sqrt(sum(line.angle_deg**2 for line in lines)))


def _alone(bench: VirtualBench, item: Imperfection, nominal: UnitTrial) -> BudgetLine:
    draws = (2 if item.signed else 1) if item.solved else DRAWS
    unit_trials = [
        run_unit_trial(bench, single_deviation(bench.spec.tolerance, item, bench.spec.seed, draw))
        for draw in range(draws)
    ]
    unit = next(note.unit for note in parameters(ToleranceSpec) if note.name == item.name)
    size = f"{getattr(bench.spec.tolerance, item.name):g}" + (f" {unit}" if unit != "1" else "")
    return _line(item.name, item.label, f"±{size}" if item.signed else size, nominal, unit_trials)


def _line(name: str, words: str, tolerance: str, nominal: UnitTrial, units: Sequence[UnitTrial]) -> BudgetLine:
    failures = tuple(unit.failure for unit in units if unit.failure)
    changes = np.concatenate([np.empty((0, 3)), *(_change(nominal, unit) for unit in units if not unit.failure)])
    if not len(changes):
        nan = float("nan")
        return BudgetLine(name, words, tolerance, nan, nan, nan, len(units), failures)
    angle, depth = changes[:, :2], changes[:, 2]
    return BudgetLine(
        name=name,
        label=words,
        tolerance=tolerance,
        angle_deg=float(np.sqrt(np.mean(angle**2))),
        angle_max_deg=float(np.abs(angle).max()),
        depth=float(np.sqrt(np.mean(depth**2))),
        units=len(units),
        failures=failures,
    )


def _change(nominal: UnitTrial, unit: UnitTrial) -> FloatArray:
    """(n, 3) differences of the errors of the same images, those that both read."""
    change = (unit.corrected() - unit.truth) - (nominal.corrected() - nominal.truth)
    return np.asarray(change[np.isfinite(change).all(axis=1)])


_TRAINED = (
    "thickness",
    "friction_min",
    "marker_position",
    "camera_offset",
    "camera_distance",
    "camera_tilt_deg",
    "focal",
)
"""Imperfections that `palpate.datasets.RandomisationSpec` varies.

Others look like a pose, or cancel at rest.
"""


def recommend_randomisation(lines: Sequence[BudgetLine], tolerance: ToleranceSpec) -> dict[str, float]:
    """Select the imperfections to randomise in training: those with a tenth of the total's square.

    Returns
    -------
    dict
        Field of `ToleranceSpec` → tolerance.
    """
    least = 0.1 * sum(line.angle_deg**2 for line in lines if np.isfinite(line.angle_deg))
    chosen = [line.name for line in lines if line.name in _TRAINED and line.angle_deg**2 >= least]
    return {name: float(getattr(tolerance, name)) for name in chosen}
