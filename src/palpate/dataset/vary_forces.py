"""Forces on the wall by units that differ from the design: shared out as their markers' positions are (`vary`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray
from palpate.dataset.vary import PerturbedPresses
from palpate.fea import Press
from palpate.twin import ForceField, build_force_field


@dataclass(frozen=True, eq=False)
class RandomisedForces:
    """Force on the wall in every virtual press.

    Attributes
    ----------
    base, others
        The design, and units that differ.
    weights
        (n presses, len(others)) share of each other's difference from the base.
    """

    base: ForceField
    others: tuple[ForceField, ...]
    weights: FloatArray

    def forces(self, rotations: FloatArray, rows: NDArray[np.intp], depth_index: int) -> FloatArray:
        """(k, 3) N, dome's frame, in the virtual presses `rows` at one depth."""
        rx, ry = rotations[rows].T
        base = self.base.forces(rx, ry, depth_index)
        found = base.copy()
        for weight, other in zip(self.weights[rows].T, self.others, strict=True):
            used = np.flatnonzero(weight)
            found[used] += weight[used, None] * (other.forces(rx[used], ry[used], depth_index) - base[used])
        return found


def randomise_forces(presses: Sequence[Press], relatives: PerturbedPresses, weights: FloatArray) -> RandomisedForces:
    """The forces of units with these shares (n, k) of the differences that `relatives` have from the design."""
    others = (build_force_field(group) for group in (*relatives.frictions, *relatives.thicknesses))
    return RandomisedForces(build_force_field(presses), tuple(others), weights)
