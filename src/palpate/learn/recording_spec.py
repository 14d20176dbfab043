"""What a person may choose about learning from a recording."""

from __future__ import annotations

from typing import Literal

from palpate.core import Spec, parameter


class RecordingSpec(Spec):
    """How a recording is read and learnt from."""

    picture_px: int = parameter(
        128, unit="px", meaning="longer side of the pictures that networks see", ge=16, le=512
    )
    test_share: float = parameter(
        0.15, unit="1", meaning="share of the presses that judge and teach nothing", gt=0, lt=0.6
    )
    validation_share: float = parameter(
        0.12, unit="1", meaning="share of the presses that choose among settings and give the intervals", gt=0, lt=0.6
    )
    level: float = parameter(0.9, unit="1", meaning="share of true values that the intervals cover", ge=0.5, lt=1)
    epochs: int = parameter(
        60,
        unit="1",
        meaning="passes of the networks on pictures over the training images; up to 8/3 as many with turned ones",
        ge=1,
        le=100_000,
    )
    threads: int = parameter(2, unit="1", meaning="cores that the networks use", ge=1, le=256)
    max_images: int = parameter(
        20_000, unit="1", meaning="images that are used at most; more are thinned out by whole presses", ge=20
    )
    correspondence: Literal["grown", "nearest"] = parameter(
        "grown",
        unit="",
        meaning="how dots are found again: grown as a smooth field, or each the one nearest to its place at rest",
    )
    estimators: Literal["all", "fast", "ridge", "dots", "picture"] = parameter(
        "all",
        unit="",
        meaning="what is trained: all, all but networks on pictures, ridge alone, only on dots, only on pictures",
    )
    seed: int = parameter(0, unit="1", meaning="seed of the split, weights and batches", ge=0)
