"""Validation of a search: predicted and simulated accuracy of winner, finalists and baseline."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import combinations
from typing import Any

import numpy as np

from palpate.calibration import PredictedAccuracy
from palpate.core import FloatArray, generator
from palpate.core.report import Report

_DRAWS = 4000
"""Bootstrap samples of the simulated units. By hand."""
_SURE = 0.95
"""Share of the bootstrap samples that must agree on the order of two designs. By hand."""


@dataclass(frozen=True)
class SimulatedAccuracy:
    """Accuracy of the built units of one design on the test bench.

    Attributes
    ----------
    units
        Number of simulated units.
    images, without_pose
        Numbers of evaluated images, and of those without a pose.
    rmse_deg
        RMSE of rx and ry over all images of all units.
    p95_deg
        95th percentile over units of each unit's maximum error of rx or ry.
    depth_rmse
        RMSE of the depth, mm.
    failures
        Reasons of failed units.
    by_unit
        RMSE and maximum error (degrees) of every unit; `None` for a unit that gave no pose.
    """

    units: int
    images: int
    without_pose: int
    rmse_deg: float
    p95_deg: float
    depth_rmse: float
    failures: tuple[str, ...] = ()
    by_unit: tuple[tuple[float, float] | None, ...] = ()

    @property
    def bootstrap_intervals(self) -> FloatArray:
        """90 % bootstrap intervals (2, 2), degrees, of RMSE and 95th percentile."""
        return np.quantile(_draw_figures([self])[0], [0.05, 0.95], axis=0).T


def _draw_figures(simulated: Sequence[SimulatedAccuracy]) -> FloatArray:
    """Draw RMSE and 95th percentile (d, draws, 2), degrees, of d designs from common bootstrap samples.

    Samples are taken from the units that gave a pose with every design; nan without any.
    """
    together = zip(*(figure.by_unit for figure in simulated), strict=True)
    units = np.array([unit for unit in together if None not in unit])
    if not len(units):
        return np.full((len(simulated), _DRAWS, 2), np.nan)
    drawn = units[generator(0, "units drawn again").integers(0, len(units), (_DRAWS, len(units)))]
    rmse, worst = np.sqrt(np.mean(drawn[..., 0] ** 2, axis=1)), np.quantile(drawn[..., 1], 0.95, axis=1)
    return np.stack([rmse, worst], axis=-1).swapaxes(0, 1)


@dataclass(frozen=True)
class ValidatedDesign:
    """One design of the validation.

    Attributes
    ----------
    title
        Role of the design: winner, finalist or baseline.
    name, markers, distance
        Its skin, number of markers, and the camera's distance in mm.
    force_n
        Maximum force of any press of its twin, N.
    predicted
        Accuracy predicted by its twin.
    simulated
        Accuracy of its twin on the test bench; `None` if the simulation failed.
    trained
        Accuracy of a trained network, which uses no calibration presses; `None` without one.
    problem
        Reason why the simulation failed.
    """

    title: str
    name: str
    markers: int
    distance: float
    force_n: float
    predicted: PredictedAccuracy | None
    simulated: SimulatedAccuracy | None
    trained: SimulatedAccuracy | None = None
    problem: str = ""

    @property
    def relative_error(self) -> float:
        """Maximum relative difference of simulated and predicted accuracy, over RMSE and 95th percentile."""
        if self.simulated is None or self.predicted is None:
            return float("nan")
        expected, found = self.predicted, self.simulated
        return max(abs(found.rmse_deg / expected.rmse_deg - 1.0), abs(found.p95_deg / expected.p95_deg - 1.0))


@dataclass(frozen=True)
class SolverComparison:
    """Comparison of CalculiX and palpate: the winner, without friction, at the maximum tilt.

    Attributes
    ----------
    depth
        Maximum depth that both reached in the same state, mm.
    force_n, own_force_n
        Contact force at this depth by CalculiX and by palpate, N.
    markers_mm
        RMS distance between the two programs' marker positions at this depth.
    branches_differ_from_mm
        Depth from which only one program shows the inverted state; `None` if they agree.
    """

    depth: float
    force_n: float
    own_force_n: float
    markers_mm: float
    branches_differ_from_mm: float | None = None


@dataclass(frozen=True)
class ValidationResult:
    """Results of the test bench and of a second solver.

    Attributes
    ----------
    designs
        The winner first.
    calibration_presses
        Calibration presses of each unit before it is read by its twin.
    second, second_problem
        Comparison with CalculiX; the reason why it did not solve the press.
    """

    designs: tuple[ValidatedDesign, ...]
    calibration_presses: int
    second: SolverComparison | None = None
    second_problem: str = ""

    @property
    def order_preserved(self) -> bool:
        """Whether simulated and predicted order of the designs agree, in RMSE and 95th percentile."""
        return all((expected * found >= 0.0).all() for _, expected, found in self._pairs())

    @property
    def reversed_pairs(self) -> tuple[str, ...]:
        """Pairs of designs in reversed order of a figure that other units would confirm."""
        pairs = self._pairs(draw=True)
        return tuple(
            title for title, expected, found in pairs if (np.mean(expected * found < 0.0, axis=0) > _SURE).any()
        )

    def _pairs(self, *, draw: bool = False) -> Iterator[tuple[str, FloatArray, FloatArray]]:
        """Pairwise differences between designs, predicted (2,) and simulated (n, 2), degrees."""
        both = [(one.title, one.predicted, one.simulated) for one in self.designs if one.predicted and one.simulated]
        for (title, expected, found), (other_title, other_expected, other_found) in combinations(both, 2):
            pair = [found, other_found]
            first, second = _draw_figures(pair) if draw else np.array([[_figures(one)] for one in pair])
            yield f"{title} and {other_title}", _figures(expected) - _figures(other_expected), first - second

    def as_dict(self) -> dict[str, Any]:
        """Return the validation as JSON data."""
        return {**asdict(self), "order_preserved": self.order_preserved, "contradicted": self.reversed_pairs}


def validation_page(proof: ValidationResult | None) -> Iterator[str | Report]:
    """Yield paragraphs and table of the validation."""
    yield "## Validation"
    if proof is None:
        yield "No design was simulated: `--validate simulated` runs winner and baseline on the test bench."
    else:
        yield _table(proof.designs)
        yield " ".join(_sentences(proof))


def _figures(found: PredictedAccuracy | SimulatedAccuracy) -> FloatArray:
    return np.array([getattr(found, name) for name in _FIGURES])


def _table(designs: Sequence[ValidatedDesign]) -> Report:
    head = ["design", "skin", "markers", "camera, mm", "force, N"]
    for figure in ("RMSE", "95th percentile"):
        head += [f"{figure} predicted", "simulated", "90 % interval"]
    trained = any(one.trained for one in designs)
    head += ["network: RMSE", "95th percentile"] if trained else []
    rows = []
    for one in designs:
        spans = one.simulated.bootstrap_intervals if one.simulated else np.full((2, 2), np.nan)
        cells = []
        for name, (least, most) in zip(_FIGURES, spans, strict=True):
            cells += [f"{getattr(figure, name):.4f}°" if figure else "" for figure in (one.predicted, one.simulated)]
            cells.append(f"{least:.4f} to {most:.4f}°" if one.simulated else "")
        cells += [f"{getattr(one.trained, name):.3f}°" if one.trained else "" for name in _FIGURES] if trained else []
        first = [one.title, one.name, str(one.markers), f"{one.distance:g}", f"{one.force_n:.2f}"]
        rows.append([*first, *cells])
    return Report.of("", head, rows)


_FIGURES = ("rmse_deg", "p95_deg")


def _order(proof: ValidationResult) -> str:
    if proof.order_preserved:
        return "their order is the same"
    if not proof.reversed_pairs:
        return "their order is the same except for designs that so few units do not separate"
    return f"their order differs: of {', of '.join(proof.reversed_pairs)} the second is better"


def _sentences(proof: ValidationResult) -> Iterator[str]:
    compared = [one for one in proof.designs if one.simulated and one.predicted]
    if compared:
        counts = " and ".join(sorted({f"{one.simulated.units} units" for one in compared if one.simulated}))
        yield (
            f"{counts} of each design, pressed by finite elements on another mesh, read from rendered images after "
            f"{proof.calibration_presses} calibration presses."
        )
        yield f"Both figures differ by {100 * max(one.relative_error for one in compared):.0f} %"
        yield f"and {_order(proof)}." if len(compared) > 1 else "in RMSE and 95th percentile."
        yield "The 90 % intervals are bootstrap intervals over the simulated units."
    for one in proof.designs:
        lost = [one.problem] if one.problem else list(one.simulated.failures if one.simulated else ())
        yield from (f"{one.title} ({one.name}): {problem}" for problem in lost)
    if proof.second is not None:
        two = proof.second
        yield (
            f"CalculiX presses the winner without friction to {two.depth:.1f} mm by {two.force_n:.3f} N, palpate by "
            f"{two.own_force_n:.3f} N ({100 * (two.own_force_n / two.force_n - 1):+.1f} %); markers are "
            f"{two.markers_mm:.3f} mm apart (rms)."
        )
        if two.branches_differ_from_mm is not None:
            yield (
                f"From {two.branches_differ_from_mm:.1f} mm on one of them shows the inverted state: "
                "ask for a single state."
            )
    elif proof.second_problem:
        yield f"CalculiX did not press the winner: {proof.second_problem}"
