"""Contact force from the same markers as the pose, by a small network trained after the estimator.

It estimates the force in the wall's axes, which are the skin's turned by the wall's rotation, for the design's
stiffness. Its error has a part proportional to the force and a constant part: the half-width of an interval is
q (a + b |normal|), with a and b fitted to jittered training images and q by held-out presses (`interval`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls
from scipy.spatial.transform import Rotation

from palpate.core import BoolArray, FloatArray, PalpateError, child_seed, generator
from palpate.datasets import Dataset, draw_jitter, split_presses
from palpate.learn.calibrate import LEVEL, MOST_IMAGES, SHARE, draw_images
from palpate.learn.estimator import Estimator
from palpate.learn.interval import press_quantile
from palpate.learn.spec import TrainingSpec
from palpate.learn.train import train_on

FORCE_AXES = ("along_x_n", "along_y_n", "normal_n")
"""Components of a force in the wall's axes, N: along its x and y axes, and along its outward normal."""
_NETWORK = TrainingSpec(repeats=1)
_LEAST_N = 1e-6
"""Addition to the scale of a force, N: avoids a division by zero."""


@dataclass(frozen=True, eq=False)
class ForceHead:
    """Network of the force, with half-widths of its intervals.

    Attributes
    ----------
    network
        Its outputs are `FORCE_AXES`.
    floor, share
        (3,) N and (3,): half-width of each component's interval is floor + share · |normal|.
    level
        Share of true values that the interval covers.
    validation_error
        Errors, by name, on held-out presses that calibrated nothing, with jitter (see `train_forces`).
    """

    network: Estimator
    floor: FloatArray
    share: FloatArray
    level: float
    validation_error: Mapping[str, float]

    def predict(self, images_px: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Predict forces (n, 3) N by `FORCE_AXES` and half-widths (n, 3) N, from images (n, m, 2) px."""
        forces = self.network.predict(images_px)
        return forces, self.floor + self.share * np.abs(forces[:, 2:])


def turn_to_wall(forces: FloatArray, poses: FloatArray) -> FloatArray:
    """Rotate forces (n, 3) to the wall's axes, for poses whose first columns are rx and ry, degrees."""
    turn = np.column_stack([np.radians(poses[:, :2]), np.zeros(len(poses))])
    return np.einsum("nij,ni->nj", Rotation.from_rotvec(turn).as_matrix(), forces)


def train_forces(dataset: Dataset, seed: int = 0, device: str = "cpu") -> ForceHead:
    """Train on the training images, calibrate on half of the held-out presses and test on the rest.

    Parameters
    ----------
    dataset
        Images with their forces.
    seed, device
        See `palpate.learn.train`.

    Returns
    -------
    ForceHead
        `validation_error` has ``normal_rmse_n`` and ``tangential_rmse_n`` (each of the two components), the same with
        ``clean_`` before them for images without jitter, ``normal_rms_n`` (the forces), ``coverage`` (share of
        all components inside their intervals) and ``presses``.

    Raises
    ------
    PalpateError
        If the dataset has no forces.
    MissingExtraError
        If torch is not installed.
    """
    if dataset.forces is None:
        raise PalpateError("The dataset has no forces.", "Generate it with forces.", code="dataset-no-forces")
    kept, held = dataset.subset(validation=False), dataset.subset(validation=True)
    inside, outside = _in_wall(kept), _in_wall(held)
    network = train_on(kept, held, _NETWORK, child_seed(seed, "forces"), device, (inside, outside))
    rows = generator(seed, "force scale").permutation(len(inside))[:MOST_IMAGES]
    noisy = draw_jitter(kept.images_px[rows], dataset.spec.jitter_px, generator(seed, "force jitter"))
    off = np.abs(network.predict(noisy) - inside[rows])
    size = np.column_stack([np.ones(len(rows)), np.abs(inside[rows, 2])])
    scale = np.array([nnls(size, column)[0] for column in off.T])
    scale[:, 0] += _LEAST_N
    chosen = split_presses(held.press, child_seed(seed, "force calibration"), SHARE).validation
    images, truth, press = draw_images(held, outside, chosen, child_seed(seed, "force check"))
    found = network.predict(images)
    width = scale[:, 0] + scale[:, 1] * np.abs(found[:, 2:])
    factor = press_quantile(np.abs(found - truth) / width, press, LEVEL)
    head = ForceHead(network, factor * scale[:, 0], factor * scale[:, 1], LEVEL, {})
    return ForceHead(network, head.floor, head.share, LEVEL, _validate(head, held, outside, ~chosen, seed))


def _in_wall(part: Dataset) -> FloatArray:
    assert part.forces is not None
    return turn_to_wall(part.forces, part.poses)


def _validate(head: ForceHead, held: Dataset, truth: FloatArray, rows: BoolArray, seed: int) -> dict[str, float]:
    images, expected, press = draw_images(held, truth, rows, child_seed(seed, "force judge"))
    found, half_width = head.predict(images)
    errors = found - expected
    clean = head.network.predict(held.images_px[rows]) - truth[rows]
    kinds = {"": errors, "clean_": clean}
    return {
        **{f"{kind}normal_rmse_n": _rms(off[:, 2]) for kind, off in kinds.items()},
        **{f"{kind}tangential_rmse_n": _rms(off[:, :2]) for kind, off in kinds.items()},
        "normal_rms_n": _rms(truth[rows, 2]),
        "coverage": float((np.abs(errors) <= half_width).mean()),
        "presses": float(len(np.unique(press))),
    }


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
