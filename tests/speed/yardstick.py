"""Work that never changes, by which the speed of a machine is told: only for tests.

A third each of what palpate's own time goes into: a sparse factorisation (scipy's SuperLU, which the presses do not
use), products of dense matrices, and many small calls of numpy from Python.
"""

import time

import numpy as np
from scipy.sparse import diags, eye, kron
from scipy.sparse.linalg import splu


class Yardstick:
    """Call it for its CPU-seconds."""

    def __init__(self):
        side = diags([-1.0, 2.01, -1.0], [-1, 0, 1], shape=(160, 160))
        self._sparse = (kron(side, eye(160)) + kron(eye(160), side)).tocsc()
        self._dense = np.random.default_rng(5).normal(size=(400, 400))
        self._small = np.random.default_rng(6).normal(size=(169, 3))

    def __call__(self):
        start = time.process_time()
        splu(self._sparse)
        for _ in range(28):
            self._dense @ self._dense
        for _ in range(2800):
            length = np.linalg.norm(self._small, axis=1)
            np.cross(self._small, self._small[::-1]) / length[:, None]
        return time.process_time() - start
