"""Configuration of a training on a recording."""

from __future__ import annotations

from typing import Literal

from palpate.core import Spec, parameter


class RecordingSpec(Spec):
    """Images, split and estimators of a training on a recording."""

    picture_px: int = parameter(
        128, unit="px", meaning="longer side of the small images at the networks' input", ge=16, le=512
    )
    test_share: float = parameter(0.15, unit="1", meaning="share of the presses in the test set", gt=0, lt=0.6)
    validation_share: float = parameter(
        0.12, unit="1", meaning="share of the presses in the validation set, for settings and intervals", gt=0, lt=0.6
    )
    level: float = parameter(0.9, unit="1", meaning="coverage of the intervals", ge=0.5, lt=1)
    epochs: int = parameter(
        60,
        unit="1",
        meaning="training epochs of image networks; up to 8/3 times as many with rotated images",
        ge=1,
        le=100_000,
    )
    threads: int = parameter(2, unit="1", meaning="number of cores of the training", ge=1, le=256)
    max_images: int = parameter(
        20_000, unit="1", meaning="maximum number of images; whole presses are left out above it", ge=20
    )
    correspondence: Literal["grown", "nearest"] = parameter(
        "grown",
        unit="",
        meaning="matching of blobs to those at rest: grown as a smooth field, or nearest to the position at rest",
    )
    estimators: Literal["all", "fast", "ridge", "dots", "picture"] = parameter(
        "all",
        unit="",
        meaning="estimators to train: all, all without image networks (`fast`), closed forms (`ridge`), estimators "
        "on marker positions (`dots`), or image networks (`picture`)",
    )
    seed: int = parameter(0, unit="1", meaning="seed of the split, weights and batches", ge=0)
