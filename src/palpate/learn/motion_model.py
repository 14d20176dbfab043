"""Motion of the markers as a function of the pose, from few presses.

One press shows the displacements of all markers but only one pose, so the map from pose to displacements needs fewer
presses than its inverse. For a pose s, with the motion L(s) of the markers by a hidden lateral motion h of the press,

    u(s) = u_0(s) + L(s) h + e(s)

Here u_0 and L come from a simulation, or are zero; e is a Gaussian process over the pose, trained on the presses and
their rotations and reflections. Each press is predicted from the rest: that gives examples of the model's errors. The
estimator is a second Gaussian process, from displacements to poses. It is trained on drawn poses and their
displacements by the model, with such errors.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from scipy.linalg import eigh

from palpate.core import FloatArray, IntArray, generator
from palpate.learn.components import principal_directions
from palpate.learn.gaussian_process import COMPONENTS, LENGTHS, MOST_TUNED, STEPS, left_out, press_rows
from palpate.learn.rotation import RotationAugmentation, RotationOperators, tilt_vector
from palpate.learn.training_set import TrainingSet

_NOISES = (1e-3, 1e-2, 5e-2, 0.2, 1.0, 5.0)
"""Noises of the kernel that are tried; the left-out error chooses. By hand."""
HIDDEN_SD = np.array([1.0, 1.0, 2.0])
"""Expected hidden motion along x, y (mm) and twist (degrees); markers have a noise of 1 px. By hand."""
_SIMULATION_ERROR = 0.2
"""Relative error of a simulation before any press. By hand."""


class SimulatedMotion(Protocol):
    """Displacements by a simulation; poses (n, k) are those of the recording's table."""

    def fields(self, poses: FloatArray, hidden: FloatArray | None = None) -> FloatArray:
        """Displacements (n, 2 m) px for poses, with hidden motions (n, 3): x, y (mm) and twist (degrees)."""

    def hidden_modes(self, poses: FloatArray) -> FloatArray:
        """Displacements (n, 2 m, 3) px by a unit of each hidden motion."""


@dataclass(frozen=True, eq=False)
class MotionModel:
    """Displacements of the markers for any pose, with examples of their errors.

    Attributes
    ----------
    symmetry, simulation
        The symmetry of the sensor, and the simulation that the model corrects; `None` without them.
    poses, lengths, weights
        (r, k) poses of the presses under each element of the group, (k,) lengths of the kernel, (r, c) weights.
    basis
        (2 m, c) displacements px of the components.
    errors
        (r, c) errors of the presses that were left out, under each element, over the RMS displacement of their press.
    hidden_sd, noise_px
        (3,) deviations of the hidden motions (mm, mm, degrees), and deviation of a marker's position, px.
    """

    symmetry: RotationAugmentation | None
    simulation: SimulatedMotion | None
    poses: FloatArray
    lengths: FloatArray
    weights: FloatArray
    basis: FloatArray
    errors: FloatArray
    hidden_sd: FloatArray
    noise_px: float

    def draw(self, poses: FloatArray, seed: int = 0) -> FloatArray:
        """Displacements (n, m, 2) px of poses (n, k), with hidden motions and errors drawn at random."""
        random = generator(seed, "motion")
        chosen = random.integers(len(self.errors), size=len(poses))
        fields = _covariance(self._directed(poses), self._directed(self.poses)) @ self.weights @ self.basis.T
        if self.simulation is not None:
            fields += self.simulation.fields(poses, random.normal(size=(len(poses), 3)) * self.hidden_sd)
        share = np.sqrt(np.mean(fields**2, axis=1)) * random.choice((-1.0, 1.0), len(poses))
        fields += share[:, None] * self.errors[chosen] @ self.basis.T
        fields += random.normal(0.0, self.noise_px, fields.shape)
        return np.asarray(fields.reshape(len(poses), -1, 2) + _base_px(self.symmetry))

    def _directed(self, poses: FloatArray) -> FloatArray:
        return _directed(poses, self.symmetry) / self.lengths


def fit_motion(samples: TrainingSet, simulation: SimulatedMotion | None = None) -> MotionModel:
    """Fit the motion of the markers to training samples, whose first targets are rx and ry.

    Of more images than components, as many are taken at random.

    Parameters
    ----------
    samples
        Displacements and poses; without a rotation, the sensor has no symmetry.
    simulation
        Simulation that the model corrects.
    """
    base_px = _base_px(samples.rotation)
    rows = generator(samples.seed, "motion").permutation(np.flatnonzero(samples.train))[:COMPONENTS]
    poses, press = samples.targets[rows], samples.press_numbers[rows]
    fields = (samples.inputs[rows] - base_px).reshape(len(rows), -1)
    hidden, modes = np.zeros((len(rows), len(HIDDEN_SD))), np.zeros((*fields.shape, len(HIDDEN_SD)))
    if simulation is not None:
        fields = fields - simulation.fields(poses)
        modes = simulation.hidden_modes(poses)
        hidden = estimate_hidden(fields, modes)
    model, errors = _fit(fields - np.einsum("npk,nk->np", modes, hidden), poses, press, samples, simulation)
    if simulation is not None:  # errors of left-out presses show their hidden motions better
        hidden = hidden + estimate_hidden(errors, modes)
        model, errors = _fit(fields - np.einsum("npk,nk->np", modes, hidden), poses, press, samples, simulation)
    sizes = np.sqrt(np.mean((samples.inputs[rows] - base_px) ** 2, axis=(1, 2)))
    relative = model.errors.reshape(len(rows), -1, model.errors.shape[1]) / np.maximum(sizes, 1e-9)[:, None, None]
    sd = np.sqrt(np.mean(hidden**2, axis=0))
    sd[:2] = np.sqrt(np.mean(sd[:2] ** 2))  # the sensor has no preferred direction
    return MotionModel(**{**vars(model), "hidden_sd": sd, "errors": relative.reshape(model.errors.shape)})


def estimate_hidden(fields: FloatArray, modes: FloatArray) -> FloatArray:
    """Hidden motions (n, 3), regularised, of displacements (n, 2 m) px by their modes (n, 2 m, 3)."""
    matrix = np.einsum("npk,npl->nkl", modes, modes) + np.diag(1.0 / HIDDEN_SD**2)
    return np.asarray(np.linalg.solve(matrix, np.einsum("npk,np->nk", modes, fields)[..., None])[..., 0])


def _fit(
    fields: FloatArray,
    poses: FloatArray,
    press: IntArray,
    samples: TrainingSet,
    simulation: SimulatedMotion | None,
) -> tuple[MotionModel, FloatArray]:
    """Model of displacements (n, 2 m), and the errors (n, 2 m) of each press from all others."""
    symmetry, turns, moved, turned = samples.rotation, [np.eye(2)], fields, poses
    if symmetry is not None:
        turns = symmetry.turns(STEPS)
        operators = RotationOperators(symmetry.places_px).operators(turns)
        moved = np.stack([fields @ each.T for each in operators], axis=1).reshape(-1, fields.shape[1])
        turned = np.stack([symmetry.turn_targets(poses, each) for each in turns], axis=1).reshape(-1, poses.shape[1])
    _, directions = principal_directions(moved.T @ moved / len(moved))
    basis = directions[:, :COMPONENTS]
    components = moved @ basis
    rest = moved - components @ basis.T
    noise_px = float(np.sqrt(np.mean(rest**2)))

    directed, rows = _directed(turned, symmetry), press_rows(press, len(turns))
    best, lengths, least = 0.0, samples.scale[1], np.inf
    for length in LENGTHS:
        place = directed / (length * samples.scale[1])
        values, vectors = eigh(_covariance(place, place))
        for noise in _NOISES:
            left = left_out((np.maximum(values, 0.0), vectors), noise, components, rows)
            error = float(np.mean(left[:: len(turns)] ** 2))
            if error < least:
                best, lengths, least = noise, length * samples.scale[1], error
    values, vectors = eigh(_covariance(directed / lengths, directed / lengths))
    decomposed = np.maximum(values, 0.0), vectors
    weights = vectors @ ((vectors.T @ components) / (decomposed[0] + best)[:, None])
    errors = left_out(decomposed, best, components, rows)
    model = MotionModel(
        symmetry=symmetry,
        simulation=simulation,
        poses=turned,
        lengths=lengths,
        weights=weights,
        basis=basis,
        errors=errors,
        hidden_sd=np.zeros_like(HIDDEN_SD),
        noise_px=noise_px,
    )
    return model, errors[:: len(turns)] @ basis.T


def draw_poses(poses: FloatArray, seed: int) -> FloatArray:
    """Poses (n, k) in the range of presses (r, k), widened by 1 / (r + 1), the part that these miss."""
    random, wider = generator(seed, "poses"), 1.0 / (len(poses) + 1.0)
    count = 2 * MOST_TUNED
    azimuth, share = 2.0 * np.pi * random.random(count), np.sqrt(random.random(count))
    tilt = np.hypot(poses[:, 0], poses[:, 1]).max() * (1.0 + wider) * share
    low, high = poses[:, 2:].min(axis=0), poses[:, 2:].max(axis=0)
    others = low + (high - low) * ((1.0 + 2.0 * wider) * random.random((count, len(low))) - wider)
    return np.column_stack([tilt * np.cos(azimuth), tilt * np.sin(azimuth), others])


def add_simulation_error(fields: FloatArray, rest_px: FloatArray, seed: int) -> FloatArray:
    """Displacements (n, m, 2) px with random relative errors: smooth along the radius, and of each marker."""
    random = generator(seed, "error")
    distance = np.linalg.norm(rest_px - RotationOperators(rest_px).middle, axis=1)
    waves = np.stack([np.ones_like(distance), np.cos(np.pi * distance / distance.max())])
    share = random.normal(0.0, _SIMULATION_ERROR / np.sqrt(2.0), (len(fields), len(waves))) @ waves
    return np.asarray(fields * random.normal(1.0 + share[..., None], 0.5 * _SIMULATION_ERROR, fields.shape))


def _base_px(symmetry: RotationAugmentation | None) -> FloatArray:
    return np.zeros(2) if symmetry is None else symmetry.base_px


def _directed(poses: FloatArray, symmetry: RotationAugmentation | None) -> FloatArray:
    """Poses (n, k) with their tilts as rotation vectors."""
    if symmetry is None:
        return poses
    return np.column_stack([tilt_vector(poses[:, :2], symmetry.angles), poses[:, 2:]])


def _covariance(first: FloatArray, second: FloatArray) -> FloatArray:
    apart = (first**2).sum(axis=1)[:, None] + (second**2).sum(axis=1) - 2.0 * first @ second.T
    return np.asarray(np.exp(-0.5 * np.maximum(apart, 0.0)))
