"""Constant row offset between poses and images in the table of a recording."""

from __future__ import annotations

import numpy as np

from palpate.core import BoolArray, FloatArray
from palpate.learn.ridge import solve_ridge

_SHIFTS = (-3, -2, -1, 1, 2, 3)
"""Offsets that are tried: one to three lost or additional rows. By hand."""
_FEATURES = 30
"""Maximum number of principal components in the linear fits. By hand."""
_BETTER = 0.6
"""Maximum error over that without offset. By hand."""


def find_row_offset(features: FloatArray, targets: FloatArray, train: BoolArray) -> int:
    """Find the row offset of poses that makes them fit the images far better, or 0.

    Parameters
    ----------
    features, targets
        (n, p) features of images and (n, k) poses, in the order of the table.
    train
        (n,) images of the linear fits; the remaining images test them. Without any there is no offset.
    """
    if train.all():
        return 0
    centred = features - features.mean(axis=0)
    _, _, right = np.linalg.svd(centred[train][:2000], full_matrices=False)
    components = centred @ right[: min(_FEATURES, len(right))].T
    components /= components.std(axis=0) + 1e-9

    def error(shift: int) -> float:
        moved = np.roll(targets, shift, axis=0)
        [(weight, bias)] = solve_ridge(components[train], moved[train], [1e-2 * float(train.sum())])
        off = (components @ weight + bias - moved)[~train] / (targets.std(axis=0) + 1e-12)
        return float(np.sqrt(np.mean(off**2)))

    as_given = error(0)
    errors = {shift: error(shift) for shift in _SHIFTS}
    best = min(errors, key=lambda shift: errors[shift])
    return best if errors[best] < _BETTER * as_given else 0
