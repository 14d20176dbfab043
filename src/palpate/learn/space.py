"""Search spaces of hyperparameters: the paper's Table 1, and a smaller one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from palpate.learn.spec import TrainingSpec, paper_training

Setting = Mapping[str, Any]


@dataclass(frozen=True)
class HyperparameterSpace:
    """Finite table of settings and the evaluation of one.

    Attributes
    ----------
    choices
        Values of each setting.
    trials
        Default number of trials.
    rungs
        Epochs of the successive trainings of a trial, each complete with its own schedule; a poor trial ends before
        the last. Empty: one training as long as the protocol states.
    inner_split
        Whether trials are evaluated on presses taken from the training set, so that the held-out presses stay
        unbiased.
    trial, final
        Training of a trial, and training of the best setting.
    score
        Objective, from the clean and the jittered RMSE of the angle (degrees).
    """

    choices: Mapping[str, tuple[Any, ...]]
    trials: int
    rungs: tuple[int, ...]
    inner_split: bool
    trial: Callable[[Setting], TrainingSpec]
    final: Callable[[Setting], TrainingSpec]
    score: Callable[[float, float], float]


PAPER_SPACE = HyperparameterSpace(
    choices={"layers": (2, 3, 4, 5, 6, 7), "width": (32, 64, 128, 256, 512, 1024), "dropout": (0.0, 0.5)},
    trials=30,
    rungs=(),
    inner_split=False,
    trial=lambda setting: paper_training(**setting).model_copy(update={"members": "all"}),
    final=lambda setting: paper_training(**setting),
    score=lambda clean_deg, jittered_deg: jittered_deg,
)
"""Table 1 of Zaid et al. 2024 by its protocol: no pruning; the validation RMSE selects."""

BEST_SPACE = HyperparameterSpace(
    choices={"layers": (3, 4), "width": (128, 256), "components": (24, 48, 96), "clean_share": (0.25, 0.5, 0.75)},
    trials=9,
    rungs=(15, 45),
    inner_split=True,
    trial=lambda setting: TrainingSpec(batch=256, matrix_rate=0.0, repeats=1, **setting),
    final=lambda setting: TrainingSpec(batch=256, matrix_rate=0.0, epochs=135, repeats=3, **setting),
    score=lambda clean_deg, jittered_deg: (clean_deg * jittered_deg) ** 0.5,
)
"""Smaller space: short trainings by Adam, successive halving; the winner trains longer, three times.

Long trainings of wide networks by Muon cost twice as much for the same errors.
"""
