"""The forward pass of perceptrons that are plain arrays."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray


def evaluate_perceptrons(
    inputs: NDArray[Any], weights: Sequence[NDArray[Any]], biases: Sequence[NDArray[Any]], activation: str
) -> NDArray[Any]:
    """Outputs (r, n, k) of r perceptrons.

    Parameters
    ----------
    inputs
        (n, p), the same for each.
    weights, biases
        One (r, in, out) and one (r, out) a layer.
    activation
        ``"relu"`` or ``"silu"``, after each layer but the last.

    Examples
    --------
    >>> evaluate_perceptrons(np.ones((1, 2)), [np.ones((3, 2, 1))], [np.zeros((3, 1))], "relu").shape
    (3, 1, 1)
    """
    hidden = inputs[None]
    for number, (weight, bias) in enumerate(zip(weights, biases, strict=True)):
        if number and activation == "relu":
            hidden = np.maximum(hidden, 0.0)
        elif number:
            with np.errstate(over="ignore"):  # exp overflows to infinity where silu is 0
                hidden = hidden / (1.0 + np.exp(-hidden))
        hidden = hidden @ weight + bias[:, None, :]
    return hidden
