"""Control experiments: a split by image instead of by press, and shuffled labels."""

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
        Errors on held-out presses.
    by_image
        Errors on held-out images, whose presses are in the training set at other depths.
    """

    by_press: Metrics
    by_image: Metrics

    @property
    def optimism_factor(self) -> float:
        """RMSE of the angle with the split by press over that with the split by image."""
        return self.by_press.rmse_deg / self.by_image.rmse_deg


def compare_splits(
    dataset: Dataset,
    spec: TrainingSpec = TrainingSpec(),  # noqa: B008  (a spec is frozen)
    seed: int = 0,
) -> SplitComparison:
    """Train with a split by press and with one by image, of equal size, and compare the errors.

    Only errors are returned, so that no dataset or estimator with a split by image leaves this function.

    Parameters
    ----------
    dataset
        Images with poses, split by press.
    spec
        Settings of each training.
    seed
        Seed of the trainings and of the split by image.
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
    """Exchange poses among presses, depths kept: the images contain no information on the angle.

    Each press gets the rotation of another press of the same side of the split.
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
