"""Which presses teach, which choose, and which judge; and what is wrong with a recording as a whole."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray, generator
from palpate.recording.sight import first_duplicate

_SHIFTS = (-3, -2, -1, 1, 2, 3)
_FEATURES = 30
_BETTER = 0.6


@dataclass(frozen=True, eq=False)
class PressSplit:
    """Images (n,) by what their presses are for.

    Attributes
    ----------
    train, validation, test
        To learn from; to choose settings and intervals by; to report errors on. No press is in two of them.
    """

    train: BoolArray
    validation: BoolArray
    test: BoolArray


def split_presses(press: IntArray, test_share: float, validation_share: float, seed: int) -> PressSplit:
    """Draw presses; at least one of each kind.

    Parameters
    ----------
    press
        (n,) number of the press of each image.
    test_share, validation_share
        Shares of presses that judge and that choose.
    seed
        Seed of the draw.
    """
    numbers, member = np.unique(press, return_inverse=True)
    order = np.empty(len(numbers), int)
    order[generator(seed, "split").permutation(len(numbers))] = np.arange(len(numbers))
    judge = max(1, round(test_share * len(numbers)))
    choose = max(1, round(validation_share * len(numbers)))
    place = order[member.reshape(-1)]
    return PressSplit(place >= judge + choose, (place >= judge) & (place < judge + choose), place < judge)


def find_duplicate_images(digests: np.ndarray, poses: FloatArray) -> tuple[BoolArray, FloatArray]:
    """Images (n,) whose pixels are those of one before them, and how far their poses (n, k) are from its poses."""
    first = first_duplicate(digests)
    double = first != np.arange(len(first))
    return double, np.abs(poses - poses[first])


def find_row_offset(features: FloatArray, targets: FloatArray, train: BoolArray) -> int:
    """By how many rows poses must be moved to fit the images far better than they do; 0 where none does.

    Parameters
    ----------
    features, targets
        (n, p) what images show and (n, k) poses, in the order of the table.
    train
        (n,) images by which linear fits are made; the others judge them.
    """
    centred = features - features.mean(axis=0)
    _, _, right = np.linalg.svd(centred[train][:2000], full_matrices=False)
    components = centred @ right[: min(_FEATURES, len(right))].T
    components = np.column_stack([components / (components.std(axis=0) + 1e-9), np.ones(len(components))])

    def error(shift: int) -> float:
        moved = np.roll(targets, shift, axis=0)
        hold = 1e-2 * train.sum() * np.eye(components.shape[1])
        weight = np.linalg.solve(components[train].T @ components[train] + hold, components[train].T @ moved[train])
        off = (components @ weight - moved)[~train] / (targets.std(axis=0) + 1e-12)
        return float(np.sqrt(np.mean(off**2)))

    as_given = error(0)
    errors = {shift: error(shift) for shift in _SHIFTS}
    best = min(errors, key=lambda shift: errors[shift])
    return best if errors[best] < _BETTER * as_given else 0
