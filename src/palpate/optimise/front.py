"""The front: what was tried, which designs nothing else beats, and whether the requirements are met."""

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
"""Constraints, and what is said where one is not met."""
ENDS = {"force": "least force", "markers": "fewest markers", "price": "least price", "size": "smallest"}
"""Objectives beside the error, and the title of the design that is least in one."""


@dataclass(frozen=True)
class SkinTrial:
    """One skin that was tried.

    Attributes
    ----------
    number
        In the order of the search.
    coarse
        What was found of it.
    violations
        By how much each constraint is not met, over what is allowed; 0 or below where it is met.
    fine
        What was found of it at full fidelity; `None` where it is no finalist.
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
        """The best that is known of it."""
        return self.fine or self.coarse


@dataclass(frozen=True)
class DesignCandidate:
    """A skin with one of its options."""

    trial: SkinTrial
    option: LayoutOption

    def value(self, objective: str) -> float:
        """What is made least by an objective: degrees, N, number, price, or mm."""
        proposal = self.trial.finest
        return {
            "error": self.option.accuracy.p95_deg,
            "force": proposal.force_n,
            "markers": float(self.option.markers.count),
            "price": self.option.price,
            "size": proposal.size_mm,
        }[objective]


def coarse_errors(skins: Sequence[SkinTrial], markers: int, *, meets: bool) -> list[tuple[int, float]]:
    """Number and least error (degrees) by coarse presses of the skins that meet the constraints, or of the others."""
    chosen = ((one, one.coarse.best(markers)) for one in skins if one.feasible is meets)
    return [(one.number, best.accuracy.p95_deg) for one, best in chosen if best is not None]


def find_best(skins: Sequence[SkinTrial], markers: int) -> DesignCandidate | None:
    """The design of least error by coarse presses, of those that meet the constraints; `None` where none does."""
    fine = ((one, one.coarse.best(markers)) for one in skins if one.feasible)
    entries = (DesignCandidate(replace(one, fine=None), option) for one, option in fine if option is not None)
    return min(entries, key=lambda entry: entry.value("error"), default=None)


@dataclass(frozen=True)
class SearchBaselines:
    """What a search is held against, judged by the same presses as its skins.

    Attributes
    ----------
    random
        Skins drawn by chance, in their order.
    grid
        Skins of a grid, with its layouts.
    """

    random: tuple[SkinTrial, ...] = ()
    grid: tuple[SkinTrial, ...] = ()


@dataclass(frozen=True)
class Front:
    """What a search found.

    Attributes
    ----------
    spec
        The requirements.
    trials
        Every skin, in the order of the search.
    validation
        What winner and rivals gave on the bench; `None` where they were not played.
    baseline
        What is foreseen of the rival; `None` where it was not asked.
    search_baselines
        What the search is held against.
    """

    spec: RequirementsSpec
    trials: tuple[SkinTrial, ...]
    validation: ValidationResult | None = None
    baseline: PredictedAccuracy | None = None
    search_baselines: SearchBaselines = SearchBaselines()

    @cached_property
    def candidates(self) -> tuple[DesignCandidate, ...]:
        """Every option of every skin that meets the constraints; of finalists alone where there are any."""
        final = [one for one in self.trials if one.fine is not None and one.feasible]
        skins = final or [one for one in self.trials if one.feasible]
        return tuple(DesignCandidate(one, option) for one in skins for option in one.finest.options)

    @cached_property
    def pareto(self) -> tuple[DesignCandidate, ...]:
        """Entries that no other beats in every objective, by the first; one only where there is one objective."""
        found = [
            entry for entry in self.candidates if not any(self._beats(other, entry) for other in self.candidates)
        ]
        first = self.spec.objectives[0]
        found.sort(key=lambda entry: (entry.value(first), entry.trial.number, entry.option.markers.count))
        return tuple(found[:1] if len(self.spec.objectives) == 1 else found)

    @property
    def winner(self) -> DesignCandidate | None:
        """Of the front the first that meets the error wanted, or else the one of least error."""
        fine = [entry for entry in self.pareto if entry.value("error") <= self.spec.error_deg]
        return next(iter(fine), min(self.pareto, key=lambda entry: entry.value("error"), default=None))

    @property
    def error_threshold_deg(self) -> float:
        """Error that the ends of the front may have: what is foreseen of the rival, or what is wanted."""
        return self.baseline.p95_deg if self.baseline else self.spec.error_deg

    @property
    def extremes(self) -> tuple[tuple[str, DesignCandidate], ...]:
        """For each objective beside the error the design that is least in it, of those no worse than
        `error_threshold_deg`."""
        fine = [entry for entry in self.candidates if entry.value("error") <= self.error_threshold_deg]
        names = [name for name in self.spec.objectives if name in ENDS] if len(self.spec.objectives) > 1 else []
        return tuple(
            (ENDS[name], min(fine, key=lambda entry: (entry.value(name), entry.value("error"))))
            for name in names
            if fine
        )

    @property
    def shortfall(self) -> str:
        """What stands in the way, in a sentence; empty where the requirements are met."""
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
            return f"The least error found is {error:.3f}°, and {self.spec.error_deg:g}° is wanted."
        return ""

    def _beats(self, one: DesignCandidate, other: DesignCandidate) -> bool:
        names = self.spec.objectives
        pairs = [(one.value(name), other.value(name)) for name in names]
        return all(a <= b for a, b in pairs) and any(a < b for a, b in pairs)
