"""Ridge regression: least squares with a penalty on the weights."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray


def solve_ridge(
    inputs: NDArray[Any], targets: FloatArray, penalties: Sequence[float | FloatArray]
) -> list[tuple[FloatArray, FloatArray]]:
    """Weights (p, k) and biases (k,) for each penalty; biases are not penalised.

    Parameters
    ----------
    inputs, targets
        (n, p) and (n, k).
    penalties
        Each a number, or (p,) one an input, on the squares of the weights; unit of the squared inputs.

    Examples
    --------
    >>> inputs = np.array([[0.0], [1.0], [2.0]])
    >>> [(weight, bias)] = solve_ridge(inputs, 3.0 * inputs + 1.0, [0.0])
    >>> weight.round(9).tolist(), bias.round(9).tolist()
    ([[3.0]], [1.0])
    """
    centre, mean = inputs.mean(axis=0).astype(float), targets.mean(axis=0)
    centred = inputs - centre
    gram, right = centred.T @ centred, centred.T @ (targets - mean)
    diagonal = np.arange(len(centre))
    found = []
    for penalty in penalties:
        penalised = gram.copy()
        penalised[diagonal, diagonal] += penalty
        weight = np.linalg.solve(penalised, right)
        found.append((weight, mean - centre @ weight))
    return found
