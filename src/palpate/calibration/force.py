"""Force on the wall: the twin's, for the design's stiffness, times what a load cell says about this unit's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from palpate.calibration.tolerance import ToleranceSpec
from palpate.core import FloatArray, PalpateError

LEVEL_90 = 1.6449
"""Half-width of an interval that covers nine tenths of a normal distribution, over its standard deviation."""
_TWIN_SHARE = 0.01
"""What the twin's force is off for a unit whose stiffness is known: a share, by units of the bench."""
_FAR = 6.0
"""Standard deviations of what is known beforehand beyond which a load cell is not believed."""


class ScalarEstimate(NamedTuple):
    """A number in N and its standard deviation."""

    value: float
    sd: float

    @property
    def half_width(self) -> float:
        """Half-width of its interval of nine tenths."""
        return LEVEL_90 * self.sd


@dataclass(frozen=True)
class StiffnessScale:
    """Stiffness of a unit over that of its design: mean and standard deviation."""

    mean: float
    sd: float


@dataclass(frozen=True, eq=False)
class Force:
    """Force on the wall.

    Attributes
    ----------
    vector
        (3,) N, dome's frame.
    covariance
        (3, 3) N².
    normal
        (3,) unit normal of the wall, dome's frame.
    """

    vector: FloatArray
    covariance: FloatArray
    normal: FloatArray

    @property
    def normal_force(self) -> ScalarEstimate:
        """Along the wall's normal."""
        return self._along(self.normal)

    @property
    def tangential_force(self) -> ScalarEstimate:
        """In the wall's plane, without its direction."""
        across = self.vector - (self.vector @ self.normal) * self.normal
        size = float(np.linalg.norm(across))
        if size > 0:
            return ScalarEstimate(size, self._along(across / size).sd)
        return ScalarEstimate(0.0, float(np.sqrt(np.linalg.eigvalsh(self.covariance)[-1])))

    def _along(self, way: FloatArray) -> ScalarEstimate:
        return ScalarEstimate(float(self.vector @ way), float(np.sqrt(way @ self.covariance @ way)))


def prior_stiffness_scale(tolerance: ToleranceSpec) -> StiffnessScale:
    """Stiffness before any load cell: as designed, within the tolerance of the mix."""
    return StiffnessScale(1.0, tolerance.modulus / np.sqrt(3.0))


def scale_force(vector: FloatArray, covariance: FloatArray, scale: StiffnessScale) -> tuple[FloatArray, FloatArray]:
    """Force (3,) N and covariance (3, 3) N² of a unit from those of its design."""
    share = scale.sd**2 + (_TWIN_SHARE * scale.mean) ** 2
    return scale.mean * vector, scale.mean**2 * covariance + share * np.outer(vector, vector)


def predict_force(parts: FloatArray, half_width: FloatArray, turn: FloatArray, tolerance: ToleranceSpec) -> Force:
    """Force of a unit that no load cell has seen, from what its design would bear.

    Parameters
    ----------
    parts, half_width
        (3,) N in the wall's axes, the last its normal, and half-widths of their intervals of nine tenths.
    turn
        (3, 3) those axes as columns in the dome's frame.
    tolerance
        How far the unit may be from its design.
    """
    spread = turn * (half_width / LEVEL_90)
    return Force(*scale_force(turn @ parts, spread @ spread.T, prior_stiffness_scale(tolerance)), turn[:, 2])


def update_stiffness_scale(
    before: StiffnessScale, expected: Sequence[ScalarEstimate], measured: Sequence[float], cell_sd: float
) -> StiffnessScale:
    """What load-cell readings tell about a unit's stiffness.

    Parameters
    ----------
    before
        What is known of it.
    expected
        Force along the wall's normal of each reading, for the design's stiffness.
    measured
        The cell's readings, N.
    cell_sd
        Standard deviation of a reading, N.

    Returns
    -------
    StiffnessScale
        Mean and standard deviation after.

    Raises
    ------
    PalpateError
        If a reading is no force, or all of them together cannot be of this unit.
    """
    pairs = [(force, cell) for force, cell in zip(expected, measured, strict=True) if np.isfinite(cell)]
    if any(cell <= 0 or force.value <= 0 for force, cell in pairs):
        raise PalpateError(
            "A load cell says a force of nothing or less.",
            "Give the force on the wall in N, upward.",
            code="force-not-positive",
        )
    if not pairs:
        return before
    weight, total = before.sd**-2.0, before.mean * before.sd**-2.0
    for force, cell in pairs:
        sd = np.hypot(cell_sd, force.sd * cell / force.value) / force.value
        weight, total = weight + sd**-2.0, total + cell / force.value * sd**-2.0
    # what the twin is off about a force is alike in all of them
    found = StiffnessScale(total / weight, float(np.hypot(weight**-0.5, _TWIN_SHARE / np.sqrt(len(pairs)))))
    median = float(np.median([cell / force.value for force, cell in pairs]))
    far = abs(median - before.mean) / np.hypot(before.sd, _TWIN_SHARE)
    if far > _FAR:
        raise PalpateError(
            f"The load cell says {median:.2f} times the design's force, {far:.0f} standard deviations off.",
            "Check the cell's unit (N) and zero, or widen the tolerance of the modulus.",
            code="load-cell-scale-off",
        )
    return found
