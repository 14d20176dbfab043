"""Trained baselines: ridge and two perceptrons on markers, and a network on rendered images."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, IntArray
from palpate.core.run import Progress
from palpate.datasets import Dataset
from palpate.learn import (
    Estimator,
    ImageNetwork,
    TrainingRun,
    TrainingSet,
    calibrate_interval,
    fit_ridge,
    press_quantile,
    train,
)
from palpate_benchmark.align_to_design import align_to_design, build_dataset, design_rest
from palpate_benchmark.predictions import POSE, Predictions, half_width_column
from palpate_benchmark.read_set import BenchmarkSet
from palpate_benchmark.score import select_track
from palpate_benchmark.spec import BaselineSpec, BenchmarkDesign, Split

_LEVEL = 0.9
LEARNERS: dict[str, Callable[[Dataset, BaselineSpec], Estimator]] = {
    "ridge": lambda dataset, spec: fit_ridge(dataset),
    "paper": lambda dataset, spec: train(dataset, spec.paper, spec.seed),
    "network": lambda dataset, spec: train(dataset, spec.network, spec.seed),
}
"""Functions that train an estimator on the images of a design."""


def predict_by_markers(
    name: str, benchmark: BenchmarkSet, design: BenchmarkDesign, spec: BaselineSpec
) -> Predictions:
    """Train an estimator on markers, and predict the test images of one design.

    Parameters
    ----------
    name
        One of `LEARNERS`.
    benchmark, design, spec
        Data set, one of its designs, and settings of the baselines.

    Raises
    ------
    MissingExtraError
        If torch is not installed; ridge does not need it.
    """
    dataset = build_dataset(benchmark, design, spec.jitter_px)
    estimator = calibrate_interval(LEARNERS[name](dataset, spec), dataset, spec.seed)
    found = benchmark.markers("test", design.name)
    told = estimator.estimate(align_to_design(found, design_rest(benchmark, design)))
    return _predictions(found.image, told.pose, told.half_width)


def predict_by_images(
    benchmark: BenchmarkSet, spec: BaselineSpec, checkpoint: Path, progress: Progress
) -> Predictions:
    """Train one network on the rendered images of all designs, and predict those of the test.

    Parameters
    ----------
    benchmark, spec
        Data set, and settings of the baselines.
    checkpoint
        File of the state after each epoch; an interrupted training is resumed from it.
    progress
        Receives each epoch.

    Raises
    ------
    MissingExtraError
        If torch is not installed.
    """
    teach, calibrate, test = (_look(benchmark, split, spec.picture_px) for split in ("train", "calibrate", "test"))
    lesson = TrainingSet(
        inputs=np.concatenate([teach[1], calibrate[1]]),
        targets=np.concatenate([teach[2], calibrate[2]]),
        train=np.repeat([True, False], [len(teach[0]), len(calibrate[0])]),
        validation=np.repeat([False, True], [len(teach[0]), len(calibrate[0])]),
        seed=spec.seed,
    )
    part = ImageNetwork.train("picture", lesson, TrainingRun(spec.picture_epochs, 1, checkpoint, progress))
    half = press_quantile(np.abs(part.predict(calibrate[1]) - calibrate[2]), calibrate[3], _LEVEL)
    poses = part.predict(test[1])
    return _predictions(test[0], poses, np.broadcast_to(half, poses.shape))


def _look(
    benchmark: BenchmarkSet, split: Split, side: int
) -> tuple[IntArray, NDArray[np.uint8], FloatArray, IntArray]:
    """Read numbers (n,), small images (n, h, w), poses (n, 3) and presses (n,) of one split."""
    table, camera = select_track(benchmark.table(split), "pictures"), benchmark.spec.camera
    longer = max(camera.height_px, camera.width_px)
    size = (round(side * camera.height_px / longer), round(side * camera.width_px / longer))
    pictures = benchmark.pictures(split, table.picture.tolist(), size)
    return table.image, pictures, table.labels[:, :3], table.press


def _predictions(image: IntArray, poses: FloatArray, half_width: FloatArray) -> Predictions:
    values = dict(zip(POSE, poses.T, strict=True))
    if np.isfinite(half_width).all():
        values |= {half_width_column(name): column for name, column in zip(POSE, half_width.T, strict=True)}
    return Predictions(image, values)
