"""Controls: what a wrong split would flatter, and what is left when the labels mean nothing."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from palpate.core import generator
from palpate.datasets import Dataset
from palpate.learn.metrics import Metrics, measure_errors
from palpate.learn.spec import TrainingSpec
from palpate.learn.train import train_on


@dataclass(frozen=True)
class SplitComparison:
    """Errors of the same training under two splits of the same images, clean.

    Attributes
    ----------
    by_press
        Held-out presses: the honest figure.
    by_image
        Held-out images, whose presses stand in the training at other depths.
    """

    by_press: Metrics
    by_image: Metrics

    @property
    def optimism_factor(self) -> float:
        """How many times smaller the split by image makes the RMSE of the angle."""
        return self.by_press.rmse_deg / self.by_image.rmse_deg


def compare_splits(
    dataset: Dataset,
    spec: TrainingSpec = TrainingSpec(),  # noqa: B008  (a spec is frozen)
    seed: int = 0,
) -> SplitComparison:
    """Train once on presses and once on images drawn at random, as many, and measure what the second flatters.

    Only errors come back: no dataset can be made with a split by image, and no estimator trained on one leaves here.

    Parameters
    ----------
    dataset
        Images with poses and an honest split.
    spec
        Training of both.
    seed
        Seed of both trainings and of the split by image.
    """
    kept, held = dataset.subset(validation=False), dataset.subset(validation=True)
    drawn = np.zeros(len(dataset.poses), dtype=bool)
    drawn[generator(seed, "split by image").permutation(len(drawn))[: len(held.poses)]] = True
    return SplitComparison(
        by_press=_errors(kept, held, spec, seed),
        by_image=_errors(
            dataset.select(~drawn, validation=False), dataset.select(drawn, validation=True), spec, seed
        ),
    )


def shuffle_labels(dataset: Dataset, seed: int = 0) -> Dataset:
    """The same images with the poses of other presses, depths kept: nothing is left to learn about the angle.

    Each press gets the rotation of another one, drawn within its side of the split, so that the split stays honest.
    """
    poses = dataset.poses.copy()
    for side in (False, True):
        presses, first = np.unique(dataset.press[dataset.validation == side], return_index=True)
        rotations = dataset.poses[dataset.validation == side][first, :2]
        shuffled = rotations[generator(seed, "shuffle", int(side)).permutation(len(presses))]
        for press, rotation in zip(presses, shuffled, strict=True):
            poses[dataset.press == press, :2] = rotation
    return replace(dataset, poses=poses)


def _errors(model: Dataset, held: Dataset, spec: TrainingSpec, seed: int) -> Metrics:
    estimates = train_on(model, held, spec, seed).predict(held.images_px)
    return measure_errors(estimates, held.poses, held.space)
