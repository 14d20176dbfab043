"""Cross-validation of estimators by press, for recordings with too few presses to hold some out."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from palpate.core import FloatArray, generator
from palpate.datasets import PressSplit
from palpate.learn.member import EnsembleMember
from palpate.learn.prepare_recording import PreparedRecording

MOST_PRESSES = 40
"""Up to so many presses estimators are cross-validated; above, presses are held out."""
_FOLDS, _EACH = 10, 20
"""Number of folds, and the number of presses up to which each press is a fold."""


def count_folds(seen: PreparedRecording) -> int:
    """Number of folds of the cross-validation of a recording; 0 if it has enough presses to hold some out."""
    count = len(np.unique(seen.press))
    return 0 if count > MOST_PRESSES else count if count <= _EACH else _FOLDS


def cross_validate(
    seen: PreparedRecording, seed: int, train: Callable[[PreparedRecording], Mapping[str, EnsembleMember]]
) -> tuple[dict[str, EnsembleMember], dict[str, FloatArray]]:
    """Train on all presses; return the estimators, and held-out estimates (n, k) by name.

    Parameters
    ----------
    seen, seed
        The recording, and the seed of its folds.
    train
        Trains estimators on the training presses of a split, and makes choices on its validation presses.
    """
    presses, folds = np.unique(seen.press), count_folds(seen)
    fold = generator(seed, "folds").permutation(np.arange(len(presses)) % folds)[np.searchsorted(presses, seen.press)]
    found: dict[str, FloatArray] = {}
    for number in range(folds):
        test, validation = fold == number, fold == (number + 1) % folds
        parts = train(replace(seen, split=PressSplit(~test & ~validation, validation, test)))
        for name, estimates in estimate_parts(seen, parts).items():
            held = found.setdefault(name, np.full(estimates.shape, np.nan))
            held[test] = estimates[test]
    whole = train(replace(seen, split=PressSplit(fold > 0, fold == 0, fold < 0)))
    return dict(whole), {name: found[name] for name in whole}


def estimate_parts(seen: PreparedRecording, parts: Mapping[str, EnsembleMember]) -> dict[str, FloatArray]:
    """Estimates (n, k) of each estimator for all images, NaN if it cannot read one."""
    found = {}
    for name, part in parts.items():
        readable = seen.accepted if part.reads_markers else np.ones(len(seen.targets), bool)
        found[name] = np.full(seen.targets.shape, np.nan)
        found[name][readable] = part.predict((seen.moved if part.reads_markers else seen.pictures)[readable])
    return found
