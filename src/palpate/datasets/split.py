"""Splits by press into training, validation and test: images of one press are nearly copies."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray, PalpateError, generator
from palpate.design import TILT_SPACE, PoseSpace

SAME_POSE = 1e-6
"""Poses nearer than this are one, degrees or mm. By hand."""


class LeakageError(PalpateError):
    """Training and validation share a press, so a validation error would flatter.

    Parameters
    ----------
    problem
        Which press or pose stands on both sides.
    code
        Whether it is a press or a pose.
    """

    def __init__(self, problem: str, *, code: str) -> None:
        super().__init__(problem, "Split by press: hold out all images of a press, or none.", code=code)


def number_presses(places: FloatArray) -> IntArray:
    """Number the presses (n, 2) of rx and ry, or x and y; equal poses get equal numbers."""
    rounded = np.round(places / SAME_POSE).astype(np.int64)
    _, first, number = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return rank[number.reshape(-1)]


@dataclass(frozen=True, eq=False)
class PressSplit:
    """Images (n,) by the use of their presses.

    Attributes
    ----------
    train, validation, test
        For weights; for choices and intervals; for reported errors. No press is in two of them.
    """

    train: BoolArray
    validation: BoolArray
    test: BoolArray


def split_presses(press: IntArray, seed: int, validation_share: float, test_share: float = 0.0) -> PressSplit:
    """Draw the presses of each use: at least one for a share that is not 0, and at least one for training.

    Parameters
    ----------
    press
        (n,) number of the press of each image.
    seed
        Seed of the draw.
    validation_share, test_share
        Shares of the presses for validation and for test.

    Raises
    ------
    PalpateError
        If there are too few presses.

    Examples
    --------
    >>> int(split_presses(np.array([0, 0, 1, 1, 2, 2]), seed=0, validation_share=0.3).validation.sum())
    2
    """
    distinct = np.unique(press)
    shares = [share for share in (test_share, validation_share) if share]
    if len(distinct) <= len(shares):
        raise PalpateError(f"{len(distinct)} press cannot be split.", "Sample more poses.", code="split-few-presses")
    drawn, parts = generator(seed, "split").permutation(distinct), []
    for number, share in enumerate(shares):
        most = len(drawn) - (len(shares) - number)  # one of each use that follows
        count = int(np.clip(round(share * len(distinct)), 1, most))
        parts.append(np.isin(press, drawn[:count]))
        drawn = drawn[count:]
    test = parts[0] if test_share else np.zeros(len(press), bool)
    return PressSplit(np.isin(press, drawn), parts[-1], test)


def check_leakage(press: IntArray, poses: FloatArray, validation: BoolArray, space: PoseSpace = TILT_SPACE) -> None:
    """Check that no press and no pose has images on both sides.

    Parameters
    ----------
    press
        (n,) number of the press of each image.
    poses
        (n, 3) rx and ry (degrees), depth (mm), or the coordinates of `space`.
    validation
        (n,) whether each image is for validation.
    space
        Coordinates of the poses.

    Raises
    ------
    LeakageError
        If a press, or two presses with the same place of the obstacle, stand on both sides.
    """
    shared = np.intersect1d(press[validation], press[~validation])
    if len(shared):
        raise LeakageError(
            f"Press {shared[0]} has images in training and in validation ({len(shared)} such).",
            code="split-shares-press",
        )
    rounded = np.round(poses[:, :2] / SAME_POSE).astype(np.int64)
    held_out = {tuple(pose) for pose in rounded[validation]}
    for pose in rounded[~validation]:
        if tuple(pose) in held_out:
            parts = zip(space.components, pose * SAME_POSE, strict=False)
            shown = ", ".join(f"{item.axis} {value:.3f}{item.unit_symbol}" for item, value in parts)
            raise LeakageError(f"The pose {shown} is in training and in validation.", code="split-shares-pose")
