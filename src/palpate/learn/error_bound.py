"""Bounds on the angle's error from the Jacobian of the image, without training.

Jitter is uniform in ±a in each of the 2m pixel coordinates, so its variance is a²/3. With J = ∂U/∂(rx, ry, depth):

* *least squares*: covariance (a²/3) (JᵀJ)⁻¹, the best of the linear unbiased estimators;
* *Pitman*: mean square error of the posterior mean under a flat prior. Uniform noise has hard edges, so with
  many markers this lies far below least squares (∝ 1/m, not 1/√m);
* *floor*: the same with known depth and poses that fill the disc of tilts evenly. No estimator of one image can
  have a lower mean square error over these poses; an error below it means leakage. (Pitman's bound is no floor if it
  comes near the radius of the disc, as with 7 markers: there the prior of the disc adds information.)

Both posterior means are those of the image's linear model about the true pose.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.camera import Camera
from palpate.core import FloatArray, PalpateError, generator
from palpate.datasets import DatasetSpec, sample_poses
from palpate.learn.calibrate import DRAWS
from palpate.learn.posterior import BURN_IN, hit_and_run
from palpate.surrogate import PressField, image_jacobian

POSES = 48
"""Poses over the disc of tilts at which the bounds are averaged. By hand."""
FEWEST_IMAGES = 3
"""Minimum number of images for a derivative by depth."""
ILL_POSED = 1e8
"""Condition number of a Jacobian beyond which the pose is not determined. By hand."""
STEPS = 60
"""Steps of a random walk after burn-in. By hand."""


@dataclass(frozen=True)
class ErrorBound:
    """Bounds on the error of one jittered image at one depth, as root mean squares over the disc of tilts.

    Attributes
    ----------
    depth_mm
        Depth of the wall.
    poses
        Number of poses with a bound.
    share
        Share of the dataset's poses that have an image at this depth.
    least_squares_deg
        Over rx and ry, as the paper's RMSE.
    least_squares_depth_mm
        Of the depth.
    pitman_deg, floor_deg
        Posterior means with a flat prior, and with the depth and the disc known.
    pitman_error_deg, floor_error_deg
        Standard errors of these two, from the finite number of draws.
    """

    depth_mm: float
    poses: int
    share: float
    least_squares_deg: float
    least_squares_depth_mm: float
    pitman_deg: float
    pitman_error_deg: float
    floor_deg: float
    floor_error_deg: float


def compute_error_bounds(
    field: PressField, camera: Camera, spec: DatasetSpec, seed: int = 0
) -> tuple[ErrorBound, ...]:
    """Bound the error of the angle, or of the offset (mm), at every depth of a dataset.

    Parameters
    ----------
    field
        Positions of the design's markers.
    camera
        Camera of the design.
    spec
        Disc of tilts, jitter and images left out.
    seed
        Seed of the draws.

    Returns
    -------
    tuple[ErrorBound, ...]
        By ascending depth; depths without a bound are left out, as with one or two markers for three unknowns.

    Raises
    ------
    PalpateError
        If the obstacle is an axisymmetric body that does not tilt.
    """
    if field.space.is_line:
        raise PalpateError(
            "No bound exists for an obstacle that lies level: near the axis its place does not determine the pose.",
            "Measure errors on held-out images (palpate.learn.evaluate).",
            code="limit-obstacle-level",
        )
    limits: list[ErrorBound] = []
    if len(field.depths_mm) < FEWEST_IMAGES:
        return ()
    sampled = np.hypot(*sample_poses(spec, field.max_offset, min_tilt_deg=field.min_tilt_deg).T)
    for image in range(max(1, spec.dropped_images), len(field.depths_mm)):
        radius = min(spec.max_tilt_deg if field.max_offset is None else field.max_offset, _reach(field, image))
        if radius <= 0:
            continue
        poses = sample_poses(
            DatasetSpec(n_presses=POSES, seed=seed), radius, min_tilt_deg=min(field.min_tilt_deg, radius)
        )
        jacobian = image_jacobian(field, camera, poses, image)
        known = np.flatnonzero(np.isfinite(jacobian).all(axis=(1, 2)))
        known = known[np.linalg.cond(jacobian[known]) < ILL_POSED]
        if len(known):
            disc = np.column_stack([poses[known], np.full(len(known), radius)])
            share = float((field.labels(sampled, image)[0] != "").mean())
            depth = float(field.depths_mm[image])
            limits.append(_limit(depth, share, jacobian[known], disc, spec.jitter_px, seed))
    return tuple(limits)


def _reach(field: PressField, image: int) -> float:
    """Maximum tilt (degrees) of an unbroken run of tilts at one depth; 0 without one."""
    return max((run.last_deg for run in field.runs[image] if run.last_deg > run.first_deg), default=0.0)


def _limit(
    depth_mm: float, share: float, jacobians: FloatArray, discs: FloatArray, jitter_px: float, seed: int
) -> ErrorBound:
    covariance = jitter_px**2 / 3 * np.linalg.inv(np.swapaxes(jacobians, 1, 2) @ jacobians)
    variance = np.diagonal(covariance, axis1=1, axis2=2).mean(axis=0)
    rng = generator(seed, "limit", depth_mm)
    everywhere = np.column_stack([discs[:, :2], np.full(len(discs), np.inf)])
    pitman, pitman_error = posterior_rmse(jacobians, jitter_px, everywhere, rng)
    floor, floor_error = posterior_rmse(jacobians[:, :, :2], jitter_px, discs, rng)
    return ErrorBound(
        depth_mm=depth_mm,
        poses=len(jacobians),
        share=share,
        least_squares_deg=float(np.sqrt(variance[:2].mean())),
        least_squares_depth_mm=float(np.sqrt(variance[2])),
        pitman_deg=pitman,
        pitman_error_deg=pitman_error,
        floor_deg=floor,
        floor_error_deg=floor_error,
    )


def posterior_rmse(
    jacobians: FloatArray, jitter_px: float, discs: FloatArray, rng: np.random.Generator, draws: int = DRAWS
) -> tuple[float, float]:
    """Root mean square error of the posterior mean of rx and ry, and its standard error (degrees).

    Two walks that share the jitter but nothing else give two estimates c₁, c₂ of one posterior mean; the mean of
    c₁ c₂ is its square without the square of the walks' own noise.

    Parameters
    ----------
    jacobians
        (n, c, d) at n poses, d at least 2: rx, ry, and further unknowns.
    jitter_px
        Half-width of the uniform jitter.
    discs
        (n, 3) rx, ry and radius of the prior at each pose (degrees), infinite for none.
    rng
        Source of jitter and walks.
    draws
        Draws of jitter at each pose.
    """
    products = []
    steps, dimensions = STEPS + BURN_IN, jacobians.shape[2]
    for jacobian, disc in zip(jacobians, discs, strict=True):
        shape = np.linalg.inv(np.linalg.cholesky(jacobian.T @ jacobian)).T
        noise = np.tile(rng.uniform(-jitter_px, jitter_px, (draws, len(jacobian))), (2, 1))
        directions = rng.standard_normal((2 * draws, steps, dimensions)) @ shape.T
        places = rng.random((2 * draws, steps))
        means = hit_and_run(np.ascontiguousarray(jacobian), noise, jitter_px, directions, places, disc)
        products.append((means[:draws, :2] * means[draws:, :2]).mean(axis=1))
    squares = np.concatenate(products)
    rmse = float(np.sqrt(max(squares.mean(), 0.0)))
    error = float(squares.std() / np.sqrt(len(squares)))
    return rmse, error / (2 * rmse) if rmse > 0 else 0.0
