"""Learning curve: error by number of training presses, and its extrapolation."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from palpate.core import BoolArray, IntArray, MissingExtraError, load_extra
from palpate.learn.gaussian_process import MOST_ROWS
from palpate.learn.member import EnsembleMember, ImageRidge, MarkerNetwork, MarkerProcess, TrainingRun
from palpate.learn.training_set import TrainingSet

PRESSES = (10, 30, 100, 300, 1000, 3000)
"""Numbers of training presses, as far as the recording has them. By hand."""
_EPOCHS = 150
"""Epochs of the network of the curve: fewer than the model's, so that its errors are larger. By hand."""


@dataclass(frozen=True)
class CurvePoint:
    """Errors for a number of training presses.

    Attributes
    ----------
    presses, estimator
        Number of training presses, and the estimator.
    rmse
        One a component, on the held-out presses.
    """

    presses: int
    estimator: str
    rmse: tuple[float, ...]


def compute_learning_curve(
    samples: TrainingSet,
    press: IntArray,
    test: BoolArray,
    train: Callable[[TrainingSet, int], Iterable[EnsembleMember]],
) -> tuple[CurvePoint, ...]:
    """Compute errors for increasing numbers of presses, on the same test presses.

    Parameters
    ----------
    samples, press, test
        All samples, their presses (n,), and the test samples (n,).
    train
        Trains estimators on a number of presses; that of minimum validation error is taken.
    """
    presses, points = np.unique(press[samples.train]), []
    for count in (*(number for number in PRESSES if number < len(presses)), len(presses)):
        some = replace(samples, train=samples.train & np.isin(press, presses[:count]))
        validation = samples.inputs[samples.validation]
        best = min(train(some, count), key=lambda member: some.error(member.predict(validation)))
        error = best.predict(samples.inputs[test]) - samples.targets[test]
        points.append(CurvePoint(count, best.name, tuple(float(x) for x in np.sqrt(np.mean(error**2, axis=0)))))
    return tuple(points)


def train_quickly(samples: TrainingSet, presses: int) -> Iterator[EnsembleMember]:
    """A closed form, and a network on markers if there are enough presses and torch is installed."""
    kind = ImageRidge if samples.inputs.dtype == np.uint8 else MarkerProcess
    yield kind.train(kind.kind, samples, TrainingRun())
    if kind is MarkerProcess and presses > MOST_ROWS:
        with contextlib.suppress(MissingExtraError):
            load_extra("torch", "learn")
            from palpate.learn.train_member import train_marker_network

            yield MarkerNetwork("network", train_marker_network("network", samples, epochs=_EPOCHS, members=1))


def extrapolate_learning_curve(points: Sequence[CurvePoint]) -> str:
    """Predict the effect of twice as many presses from the last two points; empty for fewer than two.

    Fine-tuned points follow that of the pretrained model, of 0 presses; if there are fewer than two, the points of
    estimators trained from scratch count.
    """
    at = next((k for k, point in enumerate(points) if point.presses == 0), len(points))
    own = points[at + 1 :] if len(points) > at + 2 else points[:at]
    if len(own) < 2:
        return ""
    first, last = own[-2:]
    fell = 1 - np.median(np.array(last.rmse) / first.rmse)
    falls = np.log(np.array(first.rmse) / np.array(last.rmse)) / np.log(last.presses / first.presses)
    gain = float(1.0 - 2.0 ** -max(float(np.median(falls)), 0.0))
    verdict = "more presses would pay" if gain > 0.1 else "it is nearly enough" if gain > 0.04 else "it is enough"
    begin = f"From {first.presses} to {last.presses} presses the error"
    if fell < 0.0:
        return f"{begin} rose by {-fell:.0%}; these presses do not determine the effect of more."
    return f"{begin} fell by {fell:.0%}; twice as many would bring about {gain:.0%}: {verdict}."
