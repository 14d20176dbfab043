"""Gaussian processes on displacements of markers, equivariant under the symmetry of the sensor.

Displacements are reduced to principal components of all rotated and reflected presses. With a kernel k of the
components and the actions A of the group's elements g on the targets, a target has the covariance

    K(x, x') = mean over g of k(x, g x') A(g)

(Reisert & Burkhardt 2007, "Learning equivariant functions with matrix valued kernels"). This is regression on all
rotated and reflected presses at the size of the recorded ones. Length, noise and scaling of the kernel have the
minimum error of presses that are left out one at a time, in closed form (Rasmussen & Williams 2006, section 5.4.2).
Far from all presses the estimate returns to the mean, so one wrong image cannot lead it beyond the labels.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh, polar, schur

from palpate.core import FloatArray, IntArray, generator
from palpate.learn.components import principal_directions
from palpate.learn.rotation import ANGLES, RotationAugmentation, RotationOperators, tilt_angles, tilt_vector
from palpate.learn.training_set import TrainingSet, flat_features

STEPS = 12
"""Rotations of the group, evenly spaced. By hand."""
COMPONENTS, MOST_TUNED, MOST_ROWS = 60, 300, 1000
"""Maximum number of components, and of images that choose the kernel and that are kept.

Networks are better from some 1 000 presses on, and the time of one estimate grows with the number kept. By hand.
"""
_POWERS, LENGTHS, _NOISES = (0.25, 0.5, 0.75), (0.7, 1.0, 1.5, 2.2, 3.2, 5.0), (1e-4, 1e-3, 1e-2, 1e-1)
"""Kernels that are tried: power of the deviation by which components are scaled, length, noise.

The length is relative to the RMS component. The left-out error chooses. By hand.
"""
_OUTLIER, _MOST_OUTLIERS = 6.0, 0.05
"""Relative distance of images that are dropped, over the median, and their maximum share. By hand."""
FEWEST_ROWS = 20
"""Minimum number of images for choices and outliers; fewer are better read by a motion model. By hand."""


class Kernel(NamedTuple):
    """Kernel of one group of targets.

    Attributes
    ----------
    scale
        (k,) divisors of the components: their deviations to a power, times the length.
    noise
        Variance of the noise over the mean variance of the process.
    """

    scale: FloatArray
    noise: float


@dataclass(frozen=True, eq=False)
class _Presses:
    """Components (n, k) of images under each element (g, n, k), scaled targets (n, t), and presses (n,)."""

    components: FloatArray
    moved: FloatArray
    targets: FloatArray
    press: IntArray

    def rows(self, chosen: NDArray[Any]) -> _Presses:
        return _Presses(
            self.components[chosen], self.moved[:, chosen], self.targets[chosen], np.asarray(self.press[chosen])
        )


def squared_distances(first: FloatArray, second: FloatArray, scale: FloatArray) -> FloatArray:
    """Squared distances (g, n, m) of components (n, k) from moved ones (g, m, k), over `scale` (k,)."""
    own, other = first / scale, second / scale
    found = -2.0 * own @ other.transpose(0, 2, 1)
    found += (own**2).sum(axis=1)[:, None]
    found += (other**2).sum(axis=2)[:, None]
    return np.maximum(found, 0.0, out=found)


def covariance(distances: FloatArray, actions: FloatArray) -> FloatArray:
    """Covariance (n b, m b) of targets that the group acts on by `actions` (g, b, b)."""
    (group, rows, columns), width = distances.shape, actions.shape[1]
    kernels = np.exp(-0.5 * distances).reshape(group, -1)
    found = (actions.reshape(group, -1).T / group) @ kernels
    parts = found.reshape(width, width, rows, columns).transpose(2, 0, 3, 1)
    return np.asarray(parts.reshape(rows * width, columns * width))


def choose_symmetry(samples: TrainingSet) -> RotationAugmentation | None:
    """Symmetry of samples: meaning of rx and ry, with or without reflections, by left-out error."""
    symmetry = samples.rotation
    if symmetry is None or samples.train.sum() < FEWEST_ROWS:
        return symmetry

    rows = generator(samples.seed, "process").permutation(np.flatnonzero(samples.train))[:MOST_TUNED]
    found: list[tuple[float, RotationAugmentation]] = []
    for frame in dict.fromkeys((symmetry.frame_rad, None)):
        option = symmetry._replace(frame_rad=frame)
        arrays, moved = _find_components(replace(samples, rotation=option), rows)
        columns, actions = next(_groups(replace(samples, rotation=option)))
        vectors = np.stack([tilt_vector(samples.targets[rows][:, columns], angles) for angles in ANGLES], axis=-1)
        presses = _Presses(moved[0], moved, vectors / samples.scale[1][0], samples.press_numbers[rows])
        group = presses.targets.reshape(-1, len(ANGLES)), actions
        errors = [error for _, error in _choose(presses, arrays["sd"], [group])[0]]
        found += [(error, option._replace(angles=angles)) for error, angles in zip(errors, ANGLES, strict=True)]
    return min(found, key=lambda one: one[0])[1]


def train_process(samples: TrainingSet, *, doubtful: bool = True) -> dict[str, NDArray[Any]]:
    """Train a process of each group of targets; return its numbers by name, see `predict_process`.

    ``error`` is the root mean square error of the first group in presses left out, over the deviation. Unless
    `doubtful`, no image is dropped.
    """
    rows = generator(samples.seed, "process").permutation(np.flatnonzero(samples.train))[:MOST_ROWS]
    arrays, moved = _find_components(samples, rows)
    mean, sd = samples.scale
    targets = samples.targets[rows].copy()
    if samples.rotation is not None:
        targets[:, :2] = tilt_vector(targets[:, :2], samples.rotation.angles)
    presses = _Presses(moved[0], moved, (targets - mean) / sd, samples.press_numbers[rows])
    groups = list(_groups(samples))
    for last in (False, True):
        tuned = presses.rows(np.arange(min(len(presses.press), MOST_TUNED)))
        scaled = [(tuned.targets[:, columns].reshape(-1, 1), actions) for columns, actions in groups]
        chosen = [best for (best,) in _choose(tuned, arrays["sd"], scaled)]
        kernels = [kernel for kernel, _ in chosen]
        weights, apart = _solve(presses, groups, kernels)
        kept = apart <= max(_OUTLIER, float(np.quantile(apart, 1.0 - _MOST_OUTLIERS)))
        if last or kept.all() or len(rows) < FEWEST_ROWS or not doubtful:
            break
        presses = presses.rows(kept)
    arrays |= {"features": presses.components, "mean": mean, "sd_targets": sd, "error": np.array(chosen[0][1])}
    for number, ((columns, actions), kernel, found) in enumerate(zip(groups, kernels, weights, strict=True)):
        arrays |= {
            f"columns_{number}": np.array(columns),
            f"actions_{number}": actions,
            f"scale_{number}": kernel.scale,
            f"weights_{number}": found,  # one row, so that a file keeps double precision
        }
    return arrays


def _find_components(samples: TrainingSet, rows: IntArray) -> tuple[dict[str, NDArray[Any]], FloatArray]:
    """Projection and its symmetry by name, and the components (g, n, k) of images under each element."""
    symmetry, fields = samples.rotation, flat_features(samples.inputs[rows], None).astype(float)
    if symmetry is None:
        operators = np.eye(fields.shape[1])[None]
        base, mean, spread = np.zeros(fields.shape[1]), fields.mean(axis=0), np.cov(fields.T)
    else:
        rotations, base = RotationOperators(symmetry.places_px), symmetry.base_px.reshape(-1)
        turns = symmetry.turns(STEPS)
        operators = rotations.operators(turns)
        mean, spread = rotations.spread(fields - base, turns)
        inside = np.repeat(rotations.inside, 2)
        spread = spread * inside * inside[:, None]
    variance, directions = principal_directions(spread)
    basis = directions[:, : min(COMPONENTS, max(4, len(rows) * len(operators) // 4))]
    elements = _exact_group([basis.T @ operator @ basis for operator in operators])
    # components of equal variance under the group get equal scales
    variance, mixed = principal_directions(
        np.mean((elements * variance[: basis.shape[1]]) @ elements.transpose(0, 2, 1), axis=0)
    )
    basis, elements = basis @ mixed, mixed.T @ elements @ mixed
    components = (fields - base - mean) @ basis
    arrays = {
        "projection": basis,
        "offset": (base + mean) @ basis,
        "elements": elements,
        "sd": np.sqrt(np.maximum(variance, 1e-12)),
        "angles": np.array(0 if symmetry is None else ANGLES.index(symmetry.angles)),
    }
    return arrays, components @ elements.transpose(0, 2, 1)


def _exact_group(elements: Sequence[FloatArray]) -> FloatArray:
    """Nearest group (g, k, k) to interpolated rotations and reflections; the rotations come first.

    An eigenvalue of the rotation by one step is a root of unity, and a reflection is symmetric. Without this the
    covariance is neither symmetric nor positive.
    """
    if len(elements) == 1:
        return np.array(elements)
    upper, vectors = schur(polar(elements[1])[0], output="complex")
    steps = np.round(np.angle(np.diag(upper)) / (2 * np.pi) * STEPS)
    roots = np.exp(2j * np.pi * steps[None] * np.arange(STEPS)[:, None] / STEPS)
    rotations = np.real((vectors * roots[:, None, :]) @ vectors.conj().T)
    if len(elements) == STEPS:
        return np.asarray(rotations)
    mirror = np.mean(rotations @ (elements[STEPS] + elements[STEPS].T) @ rotations, axis=0)
    values, directions = np.linalg.eigh(mirror)
    return np.concatenate([rotations, rotations @ ((directions * np.sign(values)) @ directions.T)])


def _groups(samples: TrainingSet) -> Iterator[tuple[Sequence[int], FloatArray]]:
    """Targets that the group mixes, and its actions (g, b, b) on them."""
    symmetry, count = samples.rotation, samples.targets.shape[1]
    turns = np.array([np.eye(2)] if symmetry is None else symmetry.turns(STEPS))
    if symmetry is not None:
        yield (0, 1), np.array([symmetry.action(turn) for turn in turns])
    for column in range(0 if symmetry is None else 2, count):
        sign = (
            np.sign(np.linalg.det(turns)) if symmetry is not None and column in symmetry.odd else np.ones(len(turns))
        )
        yield (column,), sign[:, None, None]


def _choose(
    presses: _Presses, sd: FloatArray, groups: Sequence[tuple[FloatArray, FloatArray]]
) -> list[list[tuple[Kernel, float]]]:
    """Kernel of minimum left-out error, and that error, for each column of targets (n b, v)."""
    best: list[list[tuple[Kernel, float]]] = [[(Kernel(sd, 1.0), np.inf)] * group[0].shape[1] for group in groups]
    rows = [press_rows(presses.press, len(targets) // len(presses.press)) for targets, _ in groups]
    for power in _POWERS:
        scale = (sd**2 + (0.01 * sd[0]) ** 2) ** (0.5 * power)
        scale = scale * max(float(np.sqrt(((presses.components / scale) ** 2).sum(axis=1).mean())), 1e-9)
        distances = squared_distances(presses.components, presses.moved, scale)
        for length, (number, (targets, actions)) in product(LENGTHS, enumerate(groups)):
            decomposed = _decompose(distances / length**2, actions)
            for noise in _NOISES:
                errors = left_out(decomposed, noise * float(decomposed[0].mean()), targets, rows[number])
                for column, error in enumerate(np.sqrt(np.mean(errors**2, axis=0))):
                    if error < best[number][column][1]:
                        best[number][column] = Kernel(scale * length, noise), float(error)
    return best


def _decompose(distances: FloatArray, actions: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Eigenvalues and eigenvectors of the covariance."""
    values, vectors = eigh(covariance(distances, actions), overwrite_a=True, driver="evd")
    return np.maximum(values, 0.0), vectors


def press_rows(press: IntArray, width: int) -> list[IntArray]:
    """Rows (p, s) of the targets of each press, `width` an image; presses of as many images are together."""
    order = np.argsort(press, kind="stable")
    together: dict[int, list[IntArray]] = {}
    for images in np.split(order, np.flatnonzero(np.diff(press[order])) + 1):
        rows = (images[:, None] * width + np.arange(width)).reshape(-1)
        together.setdefault(len(rows), []).append(rows)
    return [np.array(rows) for rows in together.values()]


def left_out(
    decomposed: tuple[FloatArray, FloatArray], noise: float, targets: FloatArray, rows: Sequence[IntArray]
) -> FloatArray:
    """Errors (n, v) of the targets (n, v) of each press from all others.

    Parameters
    ----------
    decomposed, noise
        Eigenvalues (n,) and eigenvectors (n, n) of the covariance, and the variance of the noise.
    targets, rows
        The targets, and the rows (p, s) of each press, see `press_rows`.
    """
    values, vectors = decomposed
    inverse = 1.0 / (values + noise)
    weights = vectors @ (inverse[:, None] * (vectors.T @ targets))
    left = np.empty_like(weights)
    for own in rows:
        left[own] = np.linalg.solve((vectors[own] * inverse) @ vectors[own].transpose(0, 2, 1), weights[own])
    return left


def _solve(
    presses: _Presses, groups: Sequence[tuple[Sequence[int], FloatArray]], kernels: Sequence[Kernel]
) -> tuple[list[FloatArray], FloatArray]:
    """Weights (n b,) of each group of targets, and the relative distance of each image."""
    weights, apart = [], np.zeros(len(presses.press))
    for (columns, actions), kernel in zip(groups, kernels, strict=True):
        matrix = covariance(squared_distances(presses.components, presses.moved, kernel.scale), actions)
        matrix[np.diag_indices_from(matrix)] += kernel.noise * np.trace(matrix) / len(matrix)
        inverse = np.linalg.inv(matrix)
        found = inverse @ presses.targets[:, columns].reshape(-1)
        # the error of one target from all others over its deviation (Rasmussen & Williams 2006, eq. 5.12)
        size = np.abs(found) / np.sqrt(np.diag(inverse))
        size = size.reshape(-1, len(columns)).max(axis=1)
        apart = np.maximum(apart, size / max(float(np.median(size)), 1e-12))
        weights.append(found)
    return weights, apart


def move_features(arrays: Mapping[str, NDArray[Any]]) -> FloatArray:
    """Components (g, r, k) of the training images under each element of the group."""
    return np.asarray(arrays["features"] @ arrays["elements"].transpose(0, 2, 1))


def predict_process(arrays: Mapping[str, NDArray[Any]], inputs: NDArray[Any]) -> FloatArray:
    """Poses (n, t) of displacements (n, m, 2) px.

    Parameters
    ----------
    arrays
        Numbers of `train_process`: projection (p, k) and offset (k,), elements (g, k, k) of the group, features
        (r, k) of the training images, and if given moved (g, r, k), see `move_features`; and of each group of
        targets its columns, actions, scale and weights.
    inputs
        Displacements.
    """
    components = flat_features(inputs, None) @ arrays["projection"] - arrays["offset"]
    moved = arrays["moved"] if "moved" in arrays else move_features(arrays)
    found = np.tile(arrays["mean"], (len(inputs), 1))
    for number in range(sum(name.startswith("columns_") for name in arrays)):
        columns, actions, scale, weights = (
            arrays[f"{name}_{number}"] for name in ("columns", "actions", "scale", "weights")
        )
        for start in range(0, len(inputs), 256):
            distances = squared_distances(components[start : start + 256], moved, scale)
            part = (covariance(distances, actions) @ weights).reshape(-1, len(columns))
            found[start : start + 256, columns] += part * arrays["sd_targets"][columns]
    if "actions_0" in arrays and len(arrays["columns_0"]) == 2:
        found[:, :2] = tilt_angles(found[:, :2], ANGLES[int(arrays["angles"])])
    return np.asarray(found)
