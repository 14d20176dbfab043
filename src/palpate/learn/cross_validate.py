"""Cross-validation of estimators by press, for recordings with too few presses to hold some out."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from palpate.core import BoolArray, FloatArray, generator
from palpate.core.run import Progress
from palpate.datasets import PressSplit
from palpate.learn.gaussian_process import FEWEST_ROWS, MOST_ROWS
from palpate.learn.member import EnsembleMember
from palpate.learn.prepare_recording import PreparedRecording
from palpate.learn.recording_spec import RecordingSpec

MOST_PRESSES = 40
"""Up to so many presses estimators are cross-validated; above, presses are held out. By hand."""
_FOLDS = 10
"""Number of folds; fewer than `FEWEST_ROWS` presses have one each. By hand."""


def count_folds(seen: PreparedRecording, spec: RecordingSpec) -> int:
    """Number of folds of the cross-validation of a recording; 0 if presses are held out instead."""
    count = len(np.unique(seen.press))
    if count > MOST_PRESSES or len(seen.press) > MOST_ROWS or spec.estimators == "picture":
        return 0
    return count if count <= FEWEST_ROWS else _FOLDS


def cross_validate(
    seen: PreparedRecording,
    spec: RecordingSpec,
    train: Callable[[PreparedRecording], Mapping[str, EnsembleMember]],
    progress: Progress,
) -> tuple[dict[str, EnsembleMember], dict[str, FloatArray]]:
    """Train on all presses; return the estimators, and held-out estimates (n, k) by name.

    Parameters
    ----------
    seen, spec
        The recording, and the settings.
    train
        Trains estimators on the training presses of a split, and makes choices on its validation presses.
    progress
        Receives the folds, and the training on all presses.
    """
    presses, folds = np.unique(seen.press), count_folds(seen, spec)
    fold = generator(spec.seed, "folds").permutation(np.arange(len(presses)) % folds)[
        np.searchsorted(presses, seen.press)
    ]
    found: dict[str, FloatArray] = {}
    trained: Counter[str] = Counter()
    progress.plan(folds + 1)
    for number in range(folds):
        progress.begin(piece := f"fold {number + 1} of {folds}")
        test, validation = fold == number, fold == (number + 1) % folds
        parts = train(replace(seen, split=PressSplit(~test & ~validation, validation, test)))
        trained.update(list(parts))
        for name, estimates in predict_parts(seen, parts, test).items():
            found.setdefault(name, np.full(estimates.shape, np.nan))[test] = estimates[test]
        progress.finish(piece)
    progress.begin("all presses")
    whole = train(replace(seen, split=PressSplit(fold > 0, fold == 0, fold < 0)))
    progress.finish("all presses")
    # a kind that some folds were too small for has no estimates of their presses
    kept = {name: part for name, part in whole.items() if trained[name] == folds}
    return kept, {name: found[name] for name in kept}


def predict_parts(
    seen: PreparedRecording, parts: Mapping[str, EnsembleMember], rows: BoolArray
) -> dict[str, FloatArray]:
    """Estimates (n, k) of each estimator for the images `rows` (n,), NaN for others and unreadable ones."""
    found = {}
    for name, part in parts.items():
        readable = rows & seen.accepted if part.reads_markers else rows
        found[name] = np.full(seen.targets.shape, np.nan)
        if readable.any():
            found[name][readable] = part.predict((seen.moved if part.reads_markers else seen.pictures)[readable])
    return found
