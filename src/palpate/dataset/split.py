"""Training and validation are split by press: images of one press are nearly copies of each other."""

from __future__ import annotations

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray, PalpateError, generator
from palpate.design import TILT_SPACE, PoseSpace

SAME_POSE = 1e-6
"""Poses nearer than this are one, degrees or mm."""


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
    """Number the presses (n, 2) of rx and ry, or x and y, so that two with the same pose get the same number."""
    rounded = np.round(places / SAME_POSE).astype(np.int64)
    _, first, number = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.int64)
    rank[np.argsort(first)] = np.arange(len(first))
    return rank[number.reshape(-1)]


def hold_out(press: IntArray, fraction: float, seed: int) -> BoolArray:
    """Choose the presses held out for validation.

    Parameters
    ----------
    press
        (n,) number of the press of each image.
    fraction
        Share of the presses to hold out; at least one is held out and at least one is kept.
    seed
        Seed of the choice.

    Returns
    -------
    BoolArray
        (n,) whether each image is for validation.

    Examples
    --------
    >>> int(hold_out(np.array([0, 0, 1, 1, 2, 2]), 0.3, seed=0).sum())
    2
    """
    distinct = np.unique(press)
    if len(distinct) < 2:
        raise PalpateError(f"{len(distinct)} press cannot be split.", "Sample more poses.", code="split-few-presses")
    count = int(np.clip(round(fraction * len(distinct)), 1, len(distinct) - 1))
    chosen = generator(seed, "split").permutation(distinct)[:count]
    return np.isin(press, chosen)


def check_leakage(press: IntArray, poses: FloatArray, validation: BoolArray, space: PoseSpace = TILT_SPACE) -> None:
    """Check that no press and no pose has images on both sides.

    Parameters
    ----------
    press
        (n,) number of the press of each image.
    poses
        (n, 3) rx and ry (degrees), depth (mm), or what `space` says.
    validation
        (n,) whether each image is for validation.
    space
        What the columns of the poses are.

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
