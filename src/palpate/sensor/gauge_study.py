"""Gauge repeatability and reproducibility study: variance components of repeated readings.

Readings of the same parts (wall poses) by several operators, on several days, after the sensor was mounted again,

    y = µ + part + operator + day + part × operator + mounting (within operator and day) + repeatability,

are a random-effects model, as in the crossed ANOVA of the AIAG manual (*Measurement Systems Analysis*, 4th ed.).
Without several mountings by an operator on a day, their term is operator × day. With
the sequential projections M_k of its terms, the sums of squares satisfy

    E[yᵀ M_k y] = Σ_j σ_j² tr(M_k Z_j Z_jᵀ) + σ_e² tr(M_k),

a triangular system for the components (Henderson's method 1953; for balanced data the classical ANOVA). Intervals are
generalised confidence intervals: each sum of squares over a chi-square draw (Burdick, Borror & Montgomery, *Design
and Analysis of Gauge R&R Studies*, 2005). They are exact for balanced data up to simulation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from palpate.core import FloatArray, IntArray, PalpateError, generator
from palpate.core.report import Report
from palpate.datasets import read_table
from palpate.sensor.score import DRAWS

FACTORS = ("part", "operator", "day", "mounting")
"""Columns of a study; only `part` is required."""
ANGLES = ("rx", "ry", "total angle")
_COLUMNS = ("rx_deg", "ry_deg")
TERMS = {
    "part": ("part",),
    "operator": ("operator",),
    "day": ("day",),
    "part × operator": ("part", "operator"),
    "mounting": ("operator", "day", "mounting"),
}
"""Term → factors whose combinations are its levels."""
REPEATABILITY, REPRODUCIBILITY, RR = "repeatability", "reproducibility", "R&R"


class VarianceComponent(NamedTuple):
    """Variance component of one term: estimate and 95 % interval, degrees², and degrees of freedom.

    The estimate is unbiased, so it may be negative; tables show 0 then. `dof` is that of the mean square of the term;
    of a sum of components, it is that after Satterthwaite over the mean squares, at least 1.
    """

    term: str
    variance: float
    low: float
    high: float
    dof: float


@dataclass(frozen=True)
class GaugeStudy:
    """Variance components of measurands, such as rx, ry and the total angle.

    Attributes
    ----------
    readings
        Number of readings.
    components
        Measurand → components, with `REPRODUCIBILITY` and `RR` (all but the parts) as the last.
    absent
        Terms that the study does not determine.
    """

    readings: int
    components: Mapping[str, tuple[VarianceComponent, ...]]
    absent: tuple[str, ...]

    @classmethod
    def read(cls, path: Path) -> GaugeStudy:
        """Read and analyse a table of readings with the columns `FACTORS`, rx_deg and ry_deg.

        Raises
        ------
        PalpateError
            If it cannot be read, lacks a column, has an empty cell, an angle outside ± 90°, or no repeated reading.
        """
        table = read_table(path)
        missing = [name for name in ("part", *_COLUMNS) if name not in table.columns]
        if missing:
            raise PalpateError(
                f"{path.name} has no column {missing[0]}.",
                f"Give the columns {', '.join((*FACTORS, *_COLUMNS))}; operator, day and mounting may be missing.",
                code="column-missing",
            )
        if not all(
            table.is_numeric(name) and (np.abs(table.columns[name].astype(float)) <= 90.0).all() for name in _COLUMNS
        ):
            raise PalpateError(
                f"{path.name}: an angle is missing or outside ± 90°.",
                "Give rx and ry of each row in degrees.",
                code="angle-missing",
            )
        rx, ry = (table.columns[name].astype(float) for name in _COLUMNS)
        labels = {name: np.char.strip(table.columns[name].astype(str)) for name in FACTORS if name in table.columns}
        for name, each in labels.items():
            if np.isin(each, ("", "nan", "None")).any():
                raise PalpateError(
                    f"{path.name} has an empty cell in the column {name}.",
                    "Fill the column, or leave it out.",
                    code="gauge-cell-empty",
                )
        levels = {name: np.unique(each, return_inverse=True)[1].reshape(-1) for name, each in labels.items()}
        return study_repeatability(dict(zip(ANGLES, (rx, ry, np.hypot(rx, ry)), strict=True)), levels)

    def component(self, measurand: str, term: str) -> VarianceComponent:
        """Return a component; zero if the study does not determine it."""
        found = (each for each in self.components[measurand] if each.term == term)
        return next(found, VarianceComponent(term, 0.0, 0.0, 0.0, np.inf))

    @property
    def remounted(self) -> bool:
        """Whether mountings have 4 degrees of freedom or more, enough to replace a tolerance."""
        return "mounting" not in self.absent and self.component(ANGLES[0], "mounting").dof >= 4

    def report(self, tolerance_deg: float) -> Report:
        """Return a table of SDs, and of 6 SD over the width of a tolerance ± `tolerance_deg`."""
        rows = []
        for at, each in enumerate(next(iter(self.components.values()))):
            cells = []
            for parts in self.components.values():
                low, sd, high = np.sqrt(np.maximum([parts[at].low, parts[at].variance, parts[at].high], 0.0))
                share = "" if each.term == "part" else f"; {3.0 * sd / tolerance_deg:.1%}"
                cells.append(f"{sd:.3f} ({low:.3f} to {high:.3f}){share}")
            rows.append((each.term, *cells))
        note = (
            "SD in degrees, its 95 % interval, and 6 SD over the width of the tolerance. The effect of operator, day "
            "and mounting on the total angle depends on the direction of the slope. It is thus in the interaction "
            "and in the repeatability of the total angle."
        )
        return Report.of("", ("component", *self.components), rows, note)

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        parts = {name: [each._asdict() for each in found] for name, found in self.components.items()}
        return {"readings": self.readings, "components": parts, "absent": list(self.absent)}


def study_repeatability(
    values: Mapping[str, FloatArray], levels: Mapping[str, IntArray], seed: int = 0
) -> GaugeStudy:
    """Estimate the variance components of readings.

    Parameters
    ----------
    values
        Measurand → (n,) readings or their errors, degrees.
    levels
        Factor → (n,) number of its level in each reading.
    seed
        Seed of the intervals.

    Raises
    ------
    PalpateError
        If no reading is repeated under the same conditions.

    Examples
    --------
    >>> noise = 0.1 * np.random.default_rng(0).standard_normal(200)
    >>> study = study_repeatability({"rx": 5.0 + noise}, {"part": np.arange(200) // 4})
    >>> bool(abs(study.component("rx", "repeatability").variance - 0.01) < 0.002)
    True
    """
    count = len(next(iter(values.values())))
    known = {name: levels.get(name, np.zeros(count, int)) for name in FACTORS}
    found = np.full((count, 1), count**-0.5)
    bases, designs, absent = [], {}, []
    for term, factors in TERMS.items():
        labels = np.unique(np.column_stack([known[name] for name in factors]), axis=0, return_inverse=True)[1]
        design = np.eye(int(labels.max()) + 1)[labels.reshape(-1)]
        left, size, _ = np.linalg.svd(design - found @ (found.T @ design), full_matrices=False)
        basis = left[:, size > 1e-8 * count]
        cells = len(np.unique(np.column_stack([known[name] for name in factors[:-1] or factors]), axis=0))
        confounded = term == "mounting" and cells == design.shape[1]
        if basis.shape[1]:
            bases.append(basis)
            designs["operator × day" if confounded else term] = design
            found = np.hstack([found, basis])
        if confounded or not basis.shape[1]:
            absent.append(term)
    dof = np.array([each.shape[1] for each in bases] + [count - found.shape[1]], float)
    if dof[-1] < 1:
        raise PalpateError(
            f"None of the {count} readings is repeated under the same conditions.",
            "Read each part at least twice by the same operator, on the same day and mounting.",
            code="gauge-no-repetition",
        )
    expected = np.diag(dof)
    expected[:, -1] = dof
    for row, basis in enumerate(bases):
        expected[row, :-1] = [np.sum((basis.T @ design) ** 2) for design in designs.values()]
    chances = generator(seed, "gauge").chisquare(dof, (DRAWS, len(dof))) / dof
    components = {}
    for measurand, value in values.items():
        squares = np.array([np.sum((basis.T @ value) ** 2) for basis in bases])
        squares = np.append(squares, np.sum((value - found @ (found.T @ value)) ** 2))
        components[measurand] = _solve((*designs, REPEATABILITY), expected, squares, squares / chances, dof)
    return GaugeStudy(count, components, tuple(absent))


def _solve(
    terms: tuple[str, ...], expected: FloatArray, squares: FloatArray, drawn: FloatArray, dof: FloatArray
) -> tuple[VarianceComponent, ...]:
    """Solve the triangular system for the components and for each draw (d, k) of the sums of squares."""
    inverse = np.linalg.inv(expected)
    variances, draws = inverse @ squares, inverse @ drawn.T
    for name, left_out in ((REPRODUCIBILITY, ("part", REPEATABILITY)), (RR, ("part", REPRODUCIBILITY))):
        kept = np.array([term not in left_out for term in terms], float)
        size = len(squares)
        parts = (kept[:size] @ inverse) * squares
        spread = float(np.sum(parts**2 / dof[:size]))
        terms, dof = (*terms, name), np.append(dof, max(parts.sum() ** 2 / spread, 1.0) if spread else np.inf)
        variances, draws = np.append(variances, kept @ variances), np.vstack([draws, kept @ draws])
    low, high = np.maximum(np.quantile(draws, [0.025, 0.975], axis=1), 0.0)
    rows = zip(terms, variances, low, high, dof, strict=True)
    return tuple(VarianceComponent(term, *map(float, row)) for term, *row in rows)
