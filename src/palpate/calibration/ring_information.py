"""Information of rings of markers about poses, before a layout is chosen: information is additive.

With J the derivative of a marker's pixels by all parameters, every marker adds JᵀJ to the normal matrices of the fits
of an image, of the rest image and of calibration presses. The matrices of all possible rings are computed once; the
predicted error of a selection of rings is then a sum and an inverse. It is the figure of `predict_accuracy` with its
samples replaced by their expectation. The markers of a group have one noise; for another marker size, the same
matrices are weighted differently (`RingInformation.with_markers`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from palpate.calibration.fit_pose import TWIN_ERROR_SD, contact_prior_sd
from palpate.calibration.groups import sum_by_group
from palpate.calibration.identify import twin_error_sd
from palpate.calibration.mounting import MOUNTING_PARAMETERS, Mounting, mounting_prior_sd
from palpate.calibration.noise import layout_noise
from palpate.calibration.predict_accuracy import (
    AccuracySpec,
    marker_noise,
    sample_working_range,
    simulate_calibration_presses,
)
from palpate.calibration.predict_posterior import PressInformation, press_information
from palpate.calibration.scale import model_px
from palpate.calibration.tolerance import ToleranceSpec
from palpate.calibration.unit_model import (
    CAMERA_PARAMETERS,
    LEAST_SD,
    UNIT_PARAMETERS,
    UnitPosterior,
    build_unit_model,
    modelled_tolerance,
    rest_jacobian,
    unit_prior_sd,
)
from palpate.camera import Camera
from palpate.core import BoolArray, FloatArray, IntArray, generator
from palpate.core.state import State
from palpate.design import TILT_SPACE, MarkerLayout, Skin
from palpate.surrogate import LATERAL, Twin

_MARGIN_PX = 5.0
"""Minimum distance of a marker's centre from the edge of the image. By hand."""
_UNIT = len(UNIT_PARAMETERS)
_SHARED = _UNIT + 4
"""Number of parameters of the unit and its mounting, which has four."""


@dataclass(frozen=True, eq=False)
class RingInformation:
    """Information of groups of markers, about one apex.

    Attributes
    ----------
    rest
        (g, 12, 12) information of the rest image about camera and print, with the misprints of single markers as
        noise.
    rest_prior
        (12,) prior precision of camera and print.
    presses
        Information of calibration presses; `None` without any.
    common, crossed
        (g, n, n) products of the responses of the calibration presses' gradients to rest-marker errors, and (p, g, n,
        19) products of these and the gradients of images at p poses.
    reads
        (p, g, 19, 19) information of these images about contact and unit.
    touch_prior
        (8,) prior precision of a contact; infinite for entries that do not occur.
    by_mounting
        (p, 3, 4) derivative of the robot's pose by the mounting.
    inside
        (g,) whether all markers of a group are in the image at all poses.
    unit_sd, mounting_sd
        (11,) and (4,) prior standard deviations of `UNIT_PARAMETERS` and of the mounting.
    noise_px
        (g,) standard deviation of a marker coordinate in an image.
    model_px
        Standard deviation of the twin error of a coordinate that a pose fit assumes.
    twin_error
        (15,) standard deviation of the twin error that an identification assumes in `UNIT_PARAMETERS` and
        `MOUNTING_PARAMETERS`.
    """

    rest: FloatArray
    rest_prior: FloatArray
    presses: PressInformation | None
    common: FloatArray
    crossed: FloatArray
    reads: FloatArray
    touch_prior: FloatArray
    by_mounting: FloatArray
    inside: BoolArray
    unit_sd: FloatArray
    mounting_sd: FloatArray
    noise_px: FloatArray
    model_px: float
    twin_error: FloatArray

    def with_markers(
        self, skin: Skin, layout: MarkerLayout, group: IntArray, camera: Camera, noise_px: float
    ) -> RingInformation:
        """Return the information for markers of another size, by their noise in an image.

        The information of the rest image is unchanged, since misprints dominate it. `layout` has at least one marker
        of each group, of the new size, and `group` (m,) its number.
        """
        return self.with_noise(_by_group(layout_noise(skin, layout, camera, noise_px), group))

    def with_noise(self, noise_px: FloatArray) -> RingInformation:
        """Return the information for other standard deviations (g,) px of a marker coordinate."""
        before, after = (2.0 * noise**2 + self.model_px**2 for noise in (self.noise_px, noise_px))
        reads, crossed, common, known = before / after, before / after, np.ones(len(before)), self.presses
        if known is not None:
            alike = known.common_variance + noise_px**2 - self.noise_px**2
            share = (self.noise_px**2 + known.common_variance) / (noise_px**2 + alike)
            known = known._replace(
                normal=known.normal * share[:, None, None],
                by_dot=known.by_dot[:0],  # summed up already
                common_variance=alike,
            )
            crossed, common = crossed * share, share**2
        return replace(
            self,
            reads=self.reads * reads[:, None, None],
            crossed=self.crossed * crossed[:, None, None],
            common=self.common * common[:, None, None],
            presses=known,
            noise_px=noise_px,
        )

    def lower_bound(self) -> RingInformation:
        """Return the information of the minimum-variance estimator: a convex lower bound of this variance.

        Its only error is noise; with calibration presses, it knows the errors that are common to all images.
        """
        own = self.noise_px[:, None, None] ** 2
        assumed, presses = 2.0 * own + self.model_px**2, self.presses
        if presses is None:
            return replace(self, reads=self.reads * assumed / (2.0 * own), model_px=0.0)
        normal = presses.normal * (own + presses.common_variance[:, None, None]) / own
        presses = presses._replace(normal=normal, common_variance=0.0 * presses.common_variance)
        same = replace(self, presses=presses, reads=self.reads * assumed / own, model_px=0.0)
        return replace(same, common=0.0 * self.common, crossed=0.0 * self.crossed, twin_error=0.0 * self.twin_error)

    def variance(self, share: FloatArray) -> float:
        """Return the expected squared error of rx or ry (degrees²) if a share (g,) of each group is printed."""
        on = np.flatnonzero(share)
        part = share[on]
        covariance, excess, taken = self._learn(on, part)
        spread = np.linalg.cholesky(covariance + 1e-15 * np.eye(_SHARED))
        free = np.flatnonzero(np.isfinite(self.touch_prior))
        touch = len(self.touch_prior)
        carry = np.zeros((touch + _UNIT, len(free) + _SHARED))
        carry[free, np.arange(len(free))] = 1.0
        carry[touch:, len(free) :] = spread[:_UNIT]
        own = self.noise_px[on] ** 2
        model = self.model_px**2 / (2.0 * own + self.model_px**2)
        every = np.einsum("kg,pgij->kpij", np.stack([part, part * model]), self.reads[:, on], optimize=True)
        seen, off = carry.T @ every @ carry
        normal = seen + np.diag(np.append(self.touch_prior[free], np.ones(_SHARED)))
        to_robot = np.zeros((len(normal), 2, len(free) + _SHARED))
        to_robot[:, [0, 1], [0, 1]] = 1.0
        to_robot[:, :, len(free) :] = self.by_mounting[:, :2] @ spread[_UNIT:]
        gain = to_robot @ np.linalg.inv(normal)
        found = np.einsum("pai,pai->pa", gain, to_robot - gain @ off)
        if taken is not None:
            by_shared, share = gain[:, :, len(free) :], np.linalg.solve(spread, np.linalg.solve(spread, excess).T)
            found = found - np.einsum("pai,ij,paj->pa", by_shared, share, by_shared)
            # response of the calibration presses to a rest-marker error, and of an image to that
            by_unit = gain @ seen[:, :, len(free) :] - to_robot[:, :, len(free) :]
            crossed = np.einsum("g,pgij->pij", part * own, self.crossed[:, on], optimize=True) @ carry
            again = by_unit @ np.linalg.solve(spread, taken) @ crossed
            found = found - 2.0 * np.einsum("pai,pai->pa", again, gain)
        return float(found.mean() + np.mean(TWIN_ERROR_SD[TILT_SPACE.names[:2]] ** 2))

    def _learn(self, on: IntArray, part: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray | None]:
        """Return the covariance of unit and mounting before an image, its part by twin error, and the gain.

        The covariances are (15, 15). The gain (15, n) of the calibration presses is `None` without any.
        """
        rest = np.linalg.inv(np.diag(self.rest_prior) + np.einsum("g,gij->ij", part, self.rest[on]))
        covariance = np.diag(
            np.concatenate([np.zeros(len(CAMERA_PARAMETERS)), self.unit_sd[-1:], self.mounting_sd]) ** 2
        )
        covariance[: len(CAMERA_PARAMETERS), : len(CAMERA_PARAMETERS)] = rest[
            : len(CAMERA_PARAMETERS), : len(CAMERA_PARAMETERS)
        ]
        known = self.presses
        if known is None:
            return covariance, 0.0 * covariance, None
        size = _SHARED + len(known.own_prior)
        before = np.zeros((size, size))
        before[:_SHARED, :_SHARED] = np.linalg.inv(covariance + 1e-18 * np.eye(_SHARED))
        before[np.arange(_SHARED, size), np.arange(_SHARED, size)] = known.own_prior
        normal, own = part[:, None, None] * known.normal[on], self.noise_px[on] ** 2
        model = known.common_variance[on] / (own + known.common_variance[on])
        inverse = np.linalg.inv(before + normal.sum(axis=0))
        alike, at_rest, averaged = (
            inverse @ np.einsum("g,gij->ij", share, each) @ inverse
            for share, each in (
                (part * known.common_variance[on], self.common[on]),
                (part * own, self.common[on]),
                (model, normal),
            )
        )
        off = np.diag(self.twin_error**2)
        learnt, excess = (inverse + alike)[:_SHARED, :_SHARED], (alike - at_rest + averaged)[:_SHARED, :_SHARED]
        return np.asarray(learnt + off, float), np.asarray(excess + off, float), inverse[:_SHARED]


def compute_ring_information(
    twin: Twin,
    layout: MarkerLayout,
    group: IntArray,
    camera: Camera,
    tolerance: ToleranceSpec,
    spec: AccuracySpec | None = None,
) -> RingInformation:
    """Compute the information of every group of markers that might be printed.

    Parameters
    ----------
    twin
        Twin of the skin.
    layout, group
        All markers that might be printed, and the group (m,) of each, from 0.
    camera, tolerance, spec
        As for `predict_accuracy`; ``spec.units`` is not used.
    """
    spec, tolerance = spec or AccuracySpec(), modelled_tolerance(twin, tolerance)
    rest_px = camera.project(layout.positions)
    sd = unit_prior_sd(tolerance)
    belief = UnitPosterior(camera.spec, rest_px, State.zeros(UNIT_PARAMETERS), np.diag(sd**2))
    model = build_unit_model(twin, layout, belief, tolerance)
    slopes, spread = rest_jacobian(twin, layout, camera, tolerance, spec.noise_px)
    places = sample_working_range(twin, spec, tolerance, generator(spec.seed, "foresee", "poses"))
    touch = contact_prior_sd(tolerance)
    if len(twin.inverse_frictions) == 1:
        touch = touch.replace(inverse_friction=0.0)
    mounting = Mounting(
        State.zeros(MOUNTING_PARAMETERS), np.diag(np.concatenate([sd, mounting_prior_sd(tolerance)]) ** 2)
    )
    inside = np.ones(group.max() + 1, dtype=np.bool_)
    _leave(inside, group, camera, rest_px)
    noise = _by_group(marker_noise(twin, layout, camera, spec), group)
    variance = (2.0 * noise**2 + model_px(twin.skin, camera.spec) ** 2)[group, None, None]
    presses = simulate_calibration_presses(model, spec, tolerance, generator(spec.seed, "foresee", "known presses"))
    known = press_information(model, mounting, presses, group, noise, spec.robot) if presses else None
    alike = known.by_dot if known else np.zeros((len(group), 2, 0))
    reads, crossed = [], []
    for pose, slip in places:
        looked = model.predict(pose, slip, np.zeros(3) if touch[("curvature", *LATERAL)].any() else None)
        assert looked.unit_jacobian is not None
        rows = np.zeros((len(group), 2, len(touch) + _UNIT))
        rows[..., : len(looked.pose_jacobian)] = looked.pose_jacobian.values
        rows[..., len(touch) :] = looked.unit_jacobian
        _leave(inside, group, camera, looked.pixels)
        reads.append(sum_by_group(rows, rows / variance, group))
        crossed.append(sum_by_group(alike, rows / variance, group))
    with np.errstate(divide="ignore"):
        touch_prior = touch.values**-2.0
    pad = np.full(2, max(tolerance.print_shift, LEAST_SD) / np.sqrt(3.0))
    return RingInformation(
        rest=sum_by_group(slopes, slopes / spread**2, group),
        rest_prior=np.concatenate([sd[: len(CAMERA_PARAMETERS)], pad]) ** -2.0,
        presses=known,
        common=sum_by_group(alike, alike, group),
        crossed=np.array(crossed),
        reads=np.array(reads),
        touch_prior=touch_prior,
        by_mounting=np.array([mounting.jacobian(pose) for pose, _ in places]),
        inside=inside,
        unit_sd=sd,
        mounting_sd=mounting_prior_sd(tolerance),
        noise_px=noise,
        model_px=model_px(twin.skin, camera.spec),
        twin_error=twin_error_sd(twin.skin, twin.left_out),
    )


def _by_group(noise: FloatArray, group: IntArray) -> FloatArray:
    """Return the root mean square (g,) over the markers of each group."""
    return np.asarray(np.sqrt(np.bincount(group, noise**2) / np.bincount(group)), float)


def _leave(inside: BoolArray, group: IntArray, camera: Camera, pixels: FloatArray) -> None:
    """Mark groups of which a marker leaves the image."""
    most = (camera.width_px - 1 - _MARGIN_PX, camera.height_px - 1 - _MARGIN_PX)
    there = ((pixels >= _MARGIN_PX) & (pixels <= most)).all(axis=1)
    inside[group[~there]] = False
