"""The learning curve: how the error falls with the number of presses, and what more of them would bring."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.core import BoolArray, FloatArray, IntArray, PalpateError
from palpate.dataset import PressSplit
from palpate.learn.member import EnsembleMember
from palpate.learn.train_member import train_marker_network
from palpate.learn.trainer import TrainerSpec
from palpate.learn.training_set import TrainingSet, fit_ridge_part

PRESSES = (10, 30, 100, 300, 1000, 3000)
"""Numbers of presses that are tried, as far as there are so many."""
_EPOCHS = 150
"""Epochs of the one network by which the curve is drawn: fewer than those of the model, so its errors are larger."""


@dataclass(frozen=True)
class CurvePoint:
    """Errors after a number of presses.

    Attributes
    ----------
    presses, estimator
        Number of presses that taught, and what learnt from them.
    rmse
        One a component, on the presses held out.
    """

    presses: int
    estimator: str
    rmse: tuple[float, ...]


def compute_learning_curve(
    moved: FloatArray,
    pictures: NDArray[np.uint8],
    good: BoolArray,
    targets: FloatArray,
    press: IntArray,
    split: PressSplit,
) -> tuple[CurvePoint, ...]:
    """Errors of the quickest good estimator after ever more presses; judged on the same held-out presses."""
    dots = bool(good.sum() > 0.5 * len(good))
    rows = good if dots else np.ones(len(targets), bool)
    taught = np.unique(press[split.train & rows])
    points = []
    for count in (*(number for number in PRESSES if number < len(taught)), len(taught)):
        teach = split.train & rows & np.isin(press, taught[:count])
        lesson = TrainingSet(moved if dots else pictures, targets, teach, split.validation & rows)
        tries: list[tuple[str, EnsembleMember]] = [("ridge", fit_ridge_part("ridge", lesson, not dots))]
        if dots and count >= 30:
            with contextlib.suppress(PalpateError):  # without torch, ridge draws the curve
                course = TrainerSpec(_EPOCHS, noise=0.01)
                tries.append(("network", train_marker_network("network", lesson, course, members=1)))
        inputs = lesson.inputs
        name, part = min(tries, key=lambda pair: lesson.error(pair[1].predict(inputs[lesson.validation])))
        judge = split.test & rows
        off = part.predict(inputs[judge]) - targets[judge]
        points.append(CurvePoint(count, name, tuple(float(x) for x in np.sqrt(np.mean(off**2, axis=0)))))
    return tuple(points)


def extrapolate_learning_curve(points: Sequence[CurvePoint]) -> str:
    """What twice as many presses would bring, by the law of the last two points; empty for fewer than two."""
    if len(points) < 2:
        return ""
    first, last = points[-2:]
    fell = 1 - np.median(np.array(last.rmse) / first.rmse)
    falls = np.log(np.array(first.rmse) / np.array(last.rmse)) / np.log(last.presses / first.presses)
    gain = float(1.0 - 2.0 ** -max(float(np.median(falls)), 0.0))
    verdict = "more presses would pay" if gain > 0.1 else "it is nearly enough" if gain > 0.04 else "it is enough"
    return (
        f"From {first.presses} to {last.presses} presses the error fell by {fell:.0%}; "
        f"twice as many would bring about {gain:.0%}: {verdict}."
    )
