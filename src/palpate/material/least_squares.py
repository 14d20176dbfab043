"""Least squares with linear inequalities, solved exactly.

``min |A c - b|²`` subject to ``G c >= h`` becomes a minimum-distance problem and that one a problem of non-negative
least squares (Lawson & Hanson 1974, chapter 23).
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls

from palpate.core import FloatArray

_CUTS = 40
"""Rounds of cutting planes; four or five are usual."""
_ENOUGH = 1e-8
"""Violation of the margin of stability up to which a state is stable. By hand."""
_PLANES = 60
"""Planes added in a round, those of the worst states. By hand."""
_SINGULAR = 1e6
"""Condition number beyond which constants are held small. By hand."""


def solve_linear(A: FloatArray, b: FloatArray) -> FloatArray:
    """Solve ``min |A c - b|`` with the columns of A (n, k) scaled to one length."""
    scale = lengths(A)
    return np.asarray(np.linalg.lstsq(A / scale, b, rcond=None)[0] / scale)


def solve_bounded(A: FloatArray, b: FloatArray, G: FloatArray, h: FloatArray) -> FloatArray | None:
    """Solve ``min |A c - b|`` subject to ``G c >= h``, (m, k) and (m,).

    Returns
    -------
    (k,) array or None
        None if no c meets the inequalities.
    """
    scale = lengths(A)
    q, r = np.linalg.qr(A / scale)
    if np.linalg.cond(r) > _SINGULAR:  # the data leave constants open: of all solutions, nearly the smallest
        ridge = np.vstack([A / scale, np.eye(len(scale)) / _SINGULAR])
        q, r = np.linalg.qr(ridge)
        b = np.concatenate([b, np.zeros(len(scale))])
    inverse = np.linalg.inv(r)
    target = q.T @ b
    reduced = (G / scale) @ inverse
    right = h - reduced @ target
    length = np.linalg.norm(reduced, axis=1)
    reduced, right = reduced / length[:, None], right / length
    size = max(float(np.abs(right).max()), 1e-300)
    stacked = np.vstack([reduced.T, right / size])
    unit = np.zeros(len(stacked))
    unit[-1] = 1.0
    u, _ = nnls(stacked, unit, maxiter=30 * stacked.shape[1])
    rest = stacked @ u - unit
    if abs(rest[-1]) < 1e-12:
        return None
    z = -size * rest[:-1] / rest[-1]
    return np.asarray(inverse @ (z + target) / scale)


def solve_positive_definite(
    A: FloatArray, b: FloatArray, matrices: FloatArray, margin: float
) -> tuple[FloatArray, FloatArray] | None:
    """Solve ``min |A c - b|`` so that ``sum_k c_k M_k`` has no eigenvalue below a margin, at every state.

    The set is convex and each eigenvector gives a plane that bounds it: planes violated by the last solution are
    added (Kelley 1960) until none is violated.

    Parameters
    ----------
    A, b
        (n, k), (n,).
    matrices
        (k, m, 2, 2) symmetric matrices of m states, scaled so that 1 is their usual size.
    margin
        Minimum eigenvalue.

    Returns
    -------
    ((k,), (j, k)) arrays or None
        The solution and its active planes; None if no solution was found.
    """
    planes = np.empty((0, A.shape[1]))
    c = solve_linear(A, b)
    for _ in range(_CUTS):
        values, vectors = np.linalg.eigh(np.einsum("k,kmij->mij", c, matrices))
        worst = np.argsort(values[:, 0])[:_PLANES]
        bad = worst[values[worst, 0] < margin - _ENOUGH]
        if not len(bad):
            touching = planes[np.abs(planes @ c - margin) < 1e-6] if len(planes) else planes
            return c, touching
        v = vectors[bad, :, 0]
        planes = np.vstack([planes, np.einsum("mi,kmij,mj->mk", v, matrices[:, bad], v)])
        found = solve_bounded(A, b, planes, np.full(len(planes), margin))
        if found is None:
            return None
        c = found
    return None


def solve_signed(A: FloatArray, b: FloatArray, signs: FloatArray | None) -> FloatArray:
    """Solve ``min |A c - b|``, each constant of the sign given or zero."""
    if signs is None:
        return solve_linear(A, b)
    scale = lengths(A) * signs
    return np.asarray(nnls(A / scale, b, maxiter=100 * A.shape[1])[0] / scale)


def lengths(A: FloatArray) -> FloatArray:
    """Euclidean length (k,) of each column, 1 for a zero column; safe for very large entries."""
    size = np.abs(A).max(axis=0, initial=0.0)
    size = np.where(size > 0, size, 1.0)
    length: FloatArray = size * np.linalg.norm(A / size, axis=0)
    return np.where(length > 0, length, 1.0)
