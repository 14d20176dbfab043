"""Contact force: the force of the twin, scaled by the stiffness of the unit from load-cell readings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from palpate.calibration.tolerance import ToleranceSpec
from palpate.core import FloatArray, PalpateError

LEVEL_90 = 1.6449
"""Half-width of a 90 % interval of a normal distribution, over its standard deviation."""
_TWIN_SHARE = 0.01
"""Relative error of the twin's force for a unit of known stiffness, measured on simulated units."""
_FAR = 6.0
"""Standard deviations from the prior above which load-cell readings are rejected. By hand."""


class ScalarEstimate(NamedTuple):
    """Value and standard deviation, in the unit of the quantity."""

    value: float
    sd: float

    @property
    def half_width(self) -> float:
        """Half-width of the 90 % interval."""
        return LEVEL_90 * self.sd


@dataclass(frozen=True, eq=False)
class Force:
    """Contact force `vector` (3,) N on the obstacle, in the skin's frame, with covariance (3, 3) N².

    `normal` (3,) is the unit normal of the wall.
    """

    vector: FloatArray
    covariance: FloatArray
    normal: FloatArray

    @property
    def normal_force(self) -> ScalarEstimate:
        """Component along the wall's normal."""
        return self._along(self.normal)

    @property
    def tangential_force(self) -> ScalarEstimate:
        """Magnitude of the component in the wall's plane."""
        across = self.vector - (self.vector @ self.normal) * self.normal
        size = float(np.linalg.norm(across))
        if size > 0:
            return ScalarEstimate(size, self._along(across / size).sd)
        return ScalarEstimate(0.0, float(np.sqrt(np.linalg.eigvalsh(self.covariance)[-1])))

    def _along(self, way: FloatArray) -> ScalarEstimate:
        return ScalarEstimate(float(self.vector @ way), float(np.sqrt(way @ self.covariance @ way)))


def prior_stiffness_scale(tolerance: ToleranceSpec) -> ScalarEstimate:
    """Return the stiffness before any load-cell reading: nominal, uniform within the tolerance."""
    return ScalarEstimate(1.0, tolerance.modulus / np.sqrt(3.0))


def scale_force(vector: FloatArray, covariance: FloatArray, scale: ScalarEstimate) -> tuple[FloatArray, FloatArray]:
    """Convert force (3,) N and covariance (3, 3) N² of a design to those of a unit."""
    share = scale.sd**2 + (_TWIN_SHARE * scale.value) ** 2
    return scale.value * vector, scale.value**2 * covariance + share * np.outer(vector, vector)


def predict_force(parts: FloatArray, half_width: FloatArray, turn: FloatArray, tolerance: ToleranceSpec) -> Force:
    """Predict the force of a unit without load-cell readings from the force of its design.

    `parts` (3,) N are in the axes of the wall, normal last, with half-widths of their 90 % intervals; `turn` (3, 3)
    has these axes as columns in the skin's frame.
    """
    spread = turn * (half_width / LEVEL_90)
    return Force(*scale_force(turn @ parts, spread @ spread.T, prior_stiffness_scale(tolerance)), turn[:, 2])


def update_stiffness_scale(
    before: ScalarEstimate, expected: Sequence[ScalarEstimate], measured: Sequence[float], cell_sd: float
) -> ScalarEstimate:
    """Update the stiffness scale of a unit by load-cell readings.

    Parameters
    ----------
    before
        Prior.
    expected
        Normal force of each reading at the design's stiffness.
    measured
        Readings, N; those that are not finite are ignored.
    cell_sd
        Standard deviation of a reading, N.

    Returns
    -------
    ScalarEstimate
        Posterior.

    Raises
    ------
    PalpateError
        If a reading or expected force is not positive, or the median ratio is too far from the prior.
    """
    pairs = [(force, cell) for force, cell in zip(expected, measured, strict=True) if np.isfinite(cell)]
    if any(cell <= 0 or force.value <= 0 for force, cell in pairs):
        raise PalpateError(
            "A load-cell reading or its expected force is not positive.",
            "Give the normal force in N, positive if the skin presses on the wall.",
            code="force-not-positive",
        )
    if not pairs:
        return before
    weight, total = before.sd**-2.0, before.value * before.sd**-2.0
    for force, cell in pairs:
        sd = np.hypot(cell_sd, force.sd * cell / force.value) / force.value
        weight, total = weight + sd**-2.0, total + cell / force.value * sd**-2.0
    # the error of the twin's force is common to all readings
    found = ScalarEstimate(total / weight, float(np.hypot(weight**-0.5, _TWIN_SHARE / np.sqrt(len(pairs)))))
    median = float(np.median([cell / force.value for force, cell in pairs]))
    far = abs(median - before.value) / np.hypot(before.sd, _TWIN_SHARE)
    if far > _FAR:
        raise PalpateError(
            f"The load cell measures {median:.2f} times the design's force, {far:.0f} standard deviations from the "
            "prior (limit: 6).",
            "Check the cell's unit (N) and zero, or widen the tolerance of the modulus.",
            code="load-cell-scale-off",
        )
    return found
