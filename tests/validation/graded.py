"""Cell boundaries that are finer at one end."""

import numpy as np
from scipy.optimize import brentq

from palpate.core import FloatArray


def graded(first: float, fine: int, count: int) -> FloatArray:
    """Cut 0…1 into `count` cells (count + 1,): `fine` of size `first`, then in geometric progression."""

    def surplus(ratio: float) -> float:
        return first * (fine + float((ratio ** np.arange(1, count - fine + 1)).sum())) - 1

    ratio = float(brentq(surplus, 0.1, 10.0))
    sizes = first * np.concatenate([np.ones(fine), ratio ** np.arange(1, count - fine + 1)])
    return np.concatenate([[0.0], np.cumsum(sizes)[:-1], [1.0]])
