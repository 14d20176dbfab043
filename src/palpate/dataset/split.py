"""Training and validation are split by press: images of one press are nearly copies of each other."""

from __future__ import annotations

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray, PalpateError, generator

SAME_POSE_DEG = 1e-6


class LeakageError(PalpateError):
    """Training and validation share a press, so a validation error would flatter.

    Parameters
    ----------
    what
        Which press or pose stands on both sides.
    """

    def __init__(self, what: str) -> None:
        super().__init__(what, "Split by press: hold out all images of a press, or none.")


def number_presses(rotations_deg: FloatArray) -> IntArray:
    """Number the presses (n, 2) of rx and ry so that two with the same pose get the same number."""
    rounded = np.round(rotations_deg / SAME_POSE_DEG).astype(np.int64)
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
    """
    distinct = np.unique(press)
    if len(distinct) < 2:
        raise PalpateError(f"{len(distinct)} press cannot be split.", "Sample more poses.")
    count = int(np.clip(round(fraction * len(distinct)), 1, len(distinct) - 1))
    chosen = generator(seed, "split").permutation(distinct)[:count]
    return np.isin(press, chosen)


def refuse_leakage(press: IntArray, poses: FloatArray, validation: BoolArray) -> None:
    """Check that no press and no pose has images on both sides.

    Parameters
    ----------
    press
        (n,) number of the press of each image.
    poses
        (n, 3) rx and ry (degrees), depth (mm).
    validation
        (n,) whether each image is for validation.

    Raises
    ------
    LeakageError
        If a press, or two presses with the same rotation of the wall, stand on both sides.
    """
    shared = np.intersect1d(press[validation], press[~validation])
    if len(shared):
        raise LeakageError(f"Press {shared[0]} has images in training and in validation ({len(shared)} such).")
    rounded = np.round(poses[:, :2] / SAME_POSE_DEG).astype(np.int64)
    held_out = {tuple(pose) for pose in rounded[validation]}
    for pose in rounded[~validation]:
        if tuple(pose) in held_out:
            rx, ry = pose * SAME_POSE_DEG
            raise LeakageError(f"The pose rx {rx:.3f}°, ry {ry:.3f}° is in training and in validation.")
