"""What a search may choose: the paper's Table 1, or our own few settings."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from palpate.learn.spec import TrainingSpec, paper_training

Setting = Mapping[str, Any]


@dataclass(frozen=True)
class HyperparameterSpace:
    """A finite table of settings and how one is tried.

    Attributes
    ----------
    choices
        The values of each setting.
    trials
        Settings tried where the user does not say.
    rungs
        Epochs of the trainings by which a trial is judged, one after the other, each complete with its own schedule;
        a hopeless trial ends before the last. Empty: one training as long as the protocol says.
    inner_split
        Whether trials are judged on presses taken from those for training, so that the held-out presses choose
        nothing and stay an honest measure.
    trial, final
        Training by which a setting is judged, and training of the setting that won.
    score
        What is made least, from the clean and the jittered RMSE of the angle (degrees).
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
"""Table 1 of Zaid et al. 2024 by its protocol: no pruning, the validation RMSE chooses and is reported."""

BEST_SPACE = HyperparameterSpace(
    choices={"layers": (3, 4), "width": (128, 256), "components": (24, 48, 96), "clean_share": (0.25, 0.5, 0.75)},
    trials=9,
    rungs=(15, 45),
    inner_split=True,
    trial=lambda setting: TrainingSpec(repeats=1, **setting),
    final=lambda setting: TrainingSpec(epochs=135, repeats=3, **setting),
    score=lambda clean_deg, jittered_deg: (clean_deg * jittered_deg) ** 0.5,
)
"""Our choice: short single trainings, halved, choose what is then trained longer and three times over."""
