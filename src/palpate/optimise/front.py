"""The front of a search: trials, Pareto-optimal designs, and whether the requirements are met."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from palpate.calibration import PredictedAccuracy
from palpate.optimise.skin_evaluation import LayoutOption, SkinEvaluation
from palpate.optimise.spec import RequirementsSpec
from palpate.optimise.validation import ValidationResult

WORDS = {
    "force": "the force on the workpiece is too great",
    "reach": "the skin cannot be pressed deep enough",
    "state": "the skin has a second, inverted state",
    "made": "it cannot be made",
}
"""Constraints, and the clause that reports a violation."""
ENDS = {"force": "minimum force", "markers": "fewest markers", "price": "minimum price", "size": "smallest"}
"""Objectives other than the error, and the title of the design that is best in each."""


@dataclass(frozen=True)
class SkinTrial:
    """One trial of the search.

    Attributes
    ----------
    number
        Order in the search.
    coarse
        Evaluation by coarse presses.
    violations
        Relative excess of each constraint over its limit; 0 or below if it is met.
    fine
        Evaluation at full fidelity; `None` if the skin is no finalist.
    """

    number: int
    coarse: SkinEvaluation
    violations: Mapping[str, float]
    fine: SkinEvaluation | None = None

    @property
    def feasible(self) -> bool:
        """Whether every constraint is met."""
        return all(violation <= 0 for violation in self.violations.values())

    @property
    def finest(self) -> SkinEvaluation:
        """Evaluation of the highest available fidelity."""
        return self.fine or self.coarse


@dataclass(frozen=True)
class DesignCandidate:
    """A skin with one of its options."""

    trial: SkinTrial
    option: LayoutOption

    def value(self, objective: str) -> float:
        """Value of an objective: degrees, N, number, price, or mm."""
        proposal = self.trial.finest
        return {
            "error": self.option.accuracy.p95_deg,
            "force": proposal.force_n,
            "markers": float(self.option.markers.count),
            "price": self.option.price,
            "size": proposal.size_mm,
        }[objective]


def coarse_errors(skins: Sequence[SkinTrial], markers: int, *, meets: bool) -> list[tuple[int, float]]:
    """Number and minimum coarse error (degrees) of the feasible skins, or of the infeasible ones."""
    chosen = ((one, one.coarse.best(markers)) for one in skins if one.feasible is meets)
    return [(one.number, best.accuracy.p95_deg) for one, best in chosen if best is not None]


def find_best(skins: Sequence[SkinTrial], markers: int) -> DesignCandidate | None:
    """Feasible design of minimum error by coarse presses; `None` without a feasible skin."""
    fine = ((one, one.coarse.best(markers)) for one in skins if one.feasible)
    entries = (DesignCandidate(replace(one, fine=None), option) for one, option in fine if option is not None)
    return min(entries, key=lambda entry: entry.value("error"), default=None)


@dataclass(frozen=True)
class SearchBaselines:
    """Baselines of a search, evaluated by the same coarse presses.

    Attributes
    ----------
    random
        Skins of a random search, in their order.
    grid
        Skins of a grid, with its layouts.
    """

    random: tuple[SkinTrial, ...] = ()
    grid: tuple[SkinTrial, ...] = ()


@dataclass(frozen=True)
class Front:
    """Result of a search.

    Attributes
    ----------
    spec
        The requirements.
    trials
        All skins, in the order of the search.
    validation
        Simulation of winner, finalists and baseline on the test bench; `None` without one.
    baseline
        Predicted accuracy of the baseline design; `None` without one.
    search_baselines
        Random search and grid.
    """

    spec: RequirementsSpec
    trials: tuple[SkinTrial, ...]
    validation: ValidationResult | None = None
    baseline: PredictedAccuracy | None = None
    search_baselines: SearchBaselines = SearchBaselines()

    @cached_property
    def candidates(self) -> tuple[DesignCandidate, ...]:
        """All options of the feasible skins; of the feasible finalists only, if there are any."""
        final = tuple(entry for entry in self.feasible if entry.trial.fine is not None)
        return final or self.feasible

    @cached_property
    def feasible(self) -> tuple[DesignCandidate, ...]:
        """All options of the feasible skins, each at its highest fidelity."""
        skins = [one for one in self.trials if one.feasible]
        return tuple(DesignCandidate(one, option) for one in skins for option in one.finest.options)

    @cached_property
    def pareto(self) -> tuple[DesignCandidate, ...]:
        """Non-dominated designs, sorted by the first objective; only the best for a single objective."""
        found = self._unbeaten(self.candidates)
        return found[:1] if len(self.spec.objectives) == 1 else found

    @cached_property
    def coarse_pareto(self) -> tuple[DesignCandidate, ...]:
        """Non-dominated designs without fine presses; empty for a single objective."""
        if len(self.spec.objectives) == 1 or self.candidates == self.feasible:
            return ()
        return tuple(entry for entry in self._unbeaten(self.feasible) if entry.trial.fine is None)

    @property
    def winner(self) -> DesignCandidate | None:
        """First design of the front that meets the required error, else the design of minimum error."""
        fine = [entry for entry in self.pareto if entry.value("error") <= self.spec.error_deg]
        return next(iter(fine), min(self.pareto, key=lambda entry: entry.value("error"), default=None))

    @property
    def error_threshold_deg(self) -> float:
        """Maximum error of the extremes: the predicted error of the baseline, else the required error."""
        return self.baseline.p95_deg if self.baseline else self.spec.error_deg

    @property
    def extremes(self) -> tuple[tuple[str, DesignCandidate], ...]:
        """Best design in each objective other than the error, among errors up to `error_threshold_deg`."""
        fine = [entry for entry in self.candidates if entry.value("error") <= self.error_threshold_deg]
        names = [name for name in self.spec.objectives if name in ENDS] if len(self.spec.objectives) > 1 else []
        return tuple(
            (ENDS[name], min(fine, key=lambda entry: (entry.value(name), entry.value("error"))))
            for name in names
            if fine
        )

    @property
    def shortfall(self) -> str:
        """Reason why the requirements are not met, as a sentence; empty if they are met."""
        if self.winner is None:
            reasons = [name for one in self.trials for name, by in one.violations.items() if by > 0]
            if not reasons:
                return "No skin was tried."
            often = max(dict.fromkeys(reasons), key=reasons.count)
            nearest = min(self.trials, key=lambda one: max(one.violations.values()))
            return (
                f"No skin of {len(self.trials)} meets the limits; of {reasons.count(often)} {WORDS[often]}. "
                f"The nearest is number {nearest.number}, over by {100 * max(nearest.violations.values()):.0f} %."
            )
        error = self.winner.value("error")
        if error > self.spec.error_deg:
            return f"The minimum error found is {error:.3f}°; the requirement is {self.spec.error_deg:g}°."
        return ""

    def _unbeaten(self, entries: Sequence[DesignCandidate]) -> tuple[DesignCandidate, ...]:
        """Return the non-dominated entries, sorted by the first objective."""
        found = [entry for entry in entries if not any(self._beats(other, entry) for other in entries)]
        first = self.spec.objectives[0]
        found.sort(key=lambda entry: (entry.value(first), entry.trial.number, entry.option.markers.count))
        return tuple(found)

    def _beats(self, one: DesignCandidate, other: DesignCandidate) -> bool:
        names = self.spec.objectives
        pairs = [(one.value(name), other.value(name)) for name in names]
        return all(a <= b for a, b in pairs) and any(a < b for a, b in pairs)
