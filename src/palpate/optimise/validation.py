"""The proof of a search: what was foreseen of the winner and its rivals, beside what they gave on the bench."""

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
"""Sets of units that are drawn from those that were played, to tell what others would have given."""
_SURE = 0.95
"""Share of these sets that must say the same before units are said to tell."""


@dataclass(frozen=True)
class SimulatedAccuracy:
    """What built units of one design gave on the bench.

    Attributes
    ----------
    units
        Units that were played.
    images, without_pose
        Images that counted, and those of them that gave no pose.
    rmse_deg
        Over rx and ry of all images of all units.
    p95_deg
        Greatest error of rx or ry that 19 of 20 units stay below.
    depth_rmse
        Of the depth, mm.
    failures
        Why units could not be played.
    by_unit
        RMSE and greatest error (degrees) of every unit; `None` of one that gave no pose.
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
        """Between what RMSE and 19 of 20 (2, 2), degrees, lie nine times in ten for units drawn from those played."""
        return np.quantile(_draw_figures([self])[0], [0.05, 0.95], axis=0).T


def _draw_figures(simulated: Sequence[SimulatedAccuracy]) -> FloatArray:
    """RMSE and error of 19 of 20 (d, draws, 2), degrees, of d designs by units drawn, alike for all of them.

    Drawn with replacement (the bootstrap) from the units that gave a pose with every design; nan without any.
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
    """One design of the proof.

    Attributes
    ----------
    title
        What it is: winner, finalist or rival.
    name, markers, distance
        Its skin, number of dots, and the camera's distance in mm.
    force_n
        Greatest force in any press of its twin, N.
    predicted
        From its twin.
    simulated
        By its twin on the bench; `None` where it could not be.
    trained
        By a trained network, which no known press tells about a unit; `None` where none was asked for.
    problem
        Why it could not be played.
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
        """Share by which what was played is farthest from what was foreseen: of RMSE and of 19 of 20 units."""
        if self.simulated is None or self.predicted is None:
            return float("nan")
        told, found = self.predicted, self.simulated
        return max(abs(found.rmse_deg / told.rmse_deg - 1.0), abs(found.p95_deg / told.p95_deg - 1.0))


@dataclass(frozen=True)
class SolverComparison:
    """The winner pressed by CalculiX, without friction at the greatest tilt, beside palpate's press.

    Attributes
    ----------
    depth
        Greatest depth that both reached in the same state, mm.
    force_n, own_force_n
        Force on the wall there by CalculiX and by palpate, N.
    markers_mm
        Root of the mean square distance of the dots of one from those of the other there.
    branches_differ_from_mm
        Depth from which one shows the inverted state and the other does not; `None` where they agree.
    """

    depth: float
    force_n: float
    own_force_n: float
    markers_mm: float
    branches_differ_from_mm: float | None = None


@dataclass(frozen=True)
class ValidationResult:
    """What the bench and a second solver say of a search.

    Attributes
    ----------
    designs
        The winner first.
    calibration_presses
        Calibration presses of each unit before it is read by its twin.
    second, second_problem
        What CalculiX found; why it did not press.
    """

    designs: tuple[ValidatedDesign, ...]
    calibration_presses: int
    second: SolverComparison | None = None
    second_problem: str = ""

    @property
    def order_preserved(self) -> bool:
        """Whether designs that were played stand in the order that was foreseen, by RMSE and by 19 of 20 units."""
        return all((told * found >= 0.0).all() for _, told, found in self._pairs())

    @property
    def reversed_pairs(self) -> tuple[str, ...]:
        """Pairs of designs that stand the other way round in a figure, and would by other units as well."""
        pairs = self._pairs(draw=True)
        return tuple(title for title, told, found in pairs if (np.mean(told * found < 0.0, axis=0) > _SURE).any())

    def _pairs(self, *, draw: bool = False) -> Iterator[tuple[str, FloatArray, FloatArray]]:
        """Of every two designs what is foreseen (2,) and was played (n, 2) of one less that of the other."""
        both = [(one.title, one.predicted, one.simulated) for one in self.designs if one.predicted and one.simulated]
        for (title, told, found), (other_title, other_told, other_found) in combinations(both, 2):
            pair = [found, other_found]
            first, second = _draw_figures(pair) if draw else np.array([[_figures(one)] for one in pair])
            yield f"{title} and {other_title}", _figures(told) - _figures(other_told), first - second

    def as_dict(self) -> dict[str, Any]:
        """As JSON data."""
        return {**asdict(self), "order_preserved": self.order_preserved, "contradicted": self.reversed_pairs}


def validation_page(proof: ValidationResult | None) -> Iterator[str | Report]:
    """Paragraphs and table of the proof."""
    yield "## Proof"
    if proof is None:
        yield "Nothing was played: `--validate simulated` plays the winner and its rivals on the bench."
    else:
        yield _table(proof.designs)
        yield " ".join(_sentences(proof))


def _figures(found: PredictedAccuracy | SimulatedAccuracy) -> FloatArray:
    return np.array([getattr(found, name) for name in _FIGURES])


def _table(designs: Sequence[ValidatedDesign]) -> Report:
    head = ["design", "skin", "dots", "camera, mm", "force, N"]
    for figure in ("RMSE", "19 of 20"):
        head += [f"{figure} foreseen", "played", "by other units"]
    trained = any(one.trained for one in designs)
    head += ["network: RMSE", "19 of 20"] if trained else []
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
        return "their order is the same but for designs that so few units do not tell apart"
    return f"their order is not the same: of {', of '.join(proof.reversed_pairs)} the other one is better"


def _sentences(proof: ValidationResult) -> Iterator[str]:
    played = [one for one in proof.designs if one.simulated and one.predicted]
    if played:
        counts = " and ".join(sorted({f"{one.simulated.units} units" for one in played if one.simulated}))
        yield (
            f"{counts} of each design, pressed by finite elements on another mesh, read from rendered images after "
            f"{proof.calibration_presses} calibration presses."
        )
        yield f"Foreseen and played are within {100 * max(one.relative_error for one in played):.0f} % of each other"
        yield f"and {_order(proof)}." if len(played) > 1 else "in both figures."
        yield "Nine in ten sets of units drawn again from those that were played give figures *by other units*."
    for one in proof.designs:
        lost = [one.problem] if one.problem else list(one.simulated.failures if one.simulated else ())
        yield from (f"{one.title} ({one.name}): {problem}" for problem in lost)
    if proof.second is not None:
        two = proof.second
        yield (
            f"CalculiX presses the winner without friction to {two.depth:.1f} mm by {two.force_n:.3f} N, palpate by "
            f"{two.own_force_n:.3f} N ({100 * (two.own_force_n / two.force_n - 1):+.1f} %); dots are "
            f"{two.markers_mm:.3f} mm apart (rms)."
        )
        if two.branches_differ_from_mm is not None:
            yield (
                f"From {two.branches_differ_from_mm:.1f} mm on one of them shows the inverted state: "
                "ask for a single state."
            )
    elif proof.second_problem:
        yield f"CalculiX did not press the winner: {proof.second_problem}"
