"""Pose fit of one image: the pose and friction that best explain the marker positions.

The fit maximises the posterior of rx, ry, depth and 1/µ. The unit parameters q are marginalised: they have a normal
distribution, and the image is linear in them near the pose, so they are fitted too and then discarded. The fit takes
Gauss-Newton steps with the twin's derivatives. Markers with large residuals get less weight, by Student's
distribution (Lange, Little & Taylor 1989). The misfit tests whether the model explains the image.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from palpate.calibration.force import LEVEL_90, Force, ScalarEstimate, prior_stiffness_scale, scale_force
from palpate.calibration.mounting import Mounting
from palpate.calibration.noise import robust_weights
from palpate.calibration.pose_fit import CONTACT_STATE, POSE, BranchState, FitState, Linear, PoseFit
from palpate.calibration.scale import model_px, scale_contact
from palpate.calibration.tolerance import ToleranceSpec
from palpate.calibration.unit_model import UNIT_PARAMETERS, PredictedImage, UnitModel
from palpate.core import FloatArray
from palpate.core.state import State
from palpate.design import Skin, rotation_vector, wall_normal
from palpate.surrogate import LATERAL, Twin

MAX_INVERSE_FRICTION = 5.0
"""Maximum 1/µ; larger values have not been observed."""
TILT_SD_DEG = 20.0
"""Prior standard deviation of a tilt. By hand."""
_DEPTH_SD = 1e3
"""Prior standard deviation of a depth, mm: nearly uninformative."""
_GAINED = 0.05
"""Product of gradient and step below which a fit ends: a step of 0.2 standard deviations.

Not used if the curvature is fitted. By hand.
"""
_STEPS, _BENT_STEPS = 12, 25
"""Maximum steps of a fit, without and with curvature, which is nearly equivalent to a change of depth.
By hand."""
_SMALL = State(CONTACT_STATE, np.array([1e-3, 1e-3, 5e-4, 5e-3, 0.02, 5e-3, 5e-3, 0.02]))
"""Change of a contact below which a fit ends."""
_TRUST = State(CONTACT_STATE, np.array([4.0, 4.0, 1.5, 1.5, 1.5, 0.5, 0.5, 2.0]))
"""Maximum step."""
_NEAR = State(CONTACT_STATE, np.array([0.4, 0.4, 0.2, 0.3, 1.0, 0.3, 0.3, 1.0]))
"""Change of a contact within which unit derivatives and outline bias are reused."""
READ = (*POSE, "inverse_friction")
"""Entries of the covariance of a reading."""
TWIN_ERROR_SD = State(READ, np.array([0.015, 0.015, 0.004, 0.03]))
"""Standard deviation of the twin error in pose (degrees, mm) and 1/µ, measured on simulated units.

The error is common to all markers. All constants of a contact were measured on a skin of the size in
`palpate.calibration.scale`.
"""
_LATERAL_FRICTION_SD = 0.2
"""Standard deviation of the twin error in 1/µ if the wall moves laterally. By hand."""
_OTHER_WALL = 2.0
"""Change of curvature between images, 1/m, above which the pose table is used again. By hand."""
_SHALLOW_MM = 0.6
"""Depth up to which tilt is poorly determined, so the next fit may start from the pose table. By hand."""
_OUTLIER = 16.0
"""Maximum squared normalised residual of a coordinate in the cost of a fit. By hand."""
_BEYOND = (0.5, 0.1)
"""Extrapolation beyond the tilts (degrees) and depths (mm) of the twin that a fit may reach. By hand."""
_DOUBTED = 1.5
"""Misfit above which an image is fitted again, from the pose table and on the second branch. By hand."""


@dataclass(eq=False)
class PoseFitter:
    """Pose fitter of one unit; each image is fitted starting from the previous contact.

    Attributes
    ----------
    model
        Model of the unit.
    noise_px
        Standard deviation of a marker coordinate in one image.
    mounting
        Mounting of the unit on its robot; if given, poses are on the robot's scale.
    scale
        Stiffness relative to the design; `None`: the prior by the tolerance.
    state
        State after the last image given to `fit`; `follow` does not change it.
    """

    model: UnitModel
    noise_px: float
    mounting: Mounting | None = None
    scale: ScalarEstimate | None = None

    def __post_init__(self) -> None:
        self._sd = contact_prior_sd(self.model.tolerance)
        skin = self.model.marker_twin.twin.skin
        self._size = skin.size
        self._near, self._trust, self._small = (scale_contact(each, skin) for each in (_NEAR, _TRUST, _SMALL))
        self._variance = 2.0 * self.noise_px**2 + model_px(skin, self.model.posterior.nominal) ** 2
        self._mean = State.zeros(CONTACT_STATE).replace(
            inverse_friction=self.model.tolerance.inverse_friction_prior[0]
        )
        slips = self.model.marker_twin.twin.inverse_frictions
        self._slips = float(slips[0]), min(float(slips[-1]), MAX_INVERSE_FRICTION)
        self._free = free_entries(self._sd, self.model.marker_twin.twin)
        self._drifts = bool((self._sd[LATERAL] > 0).any())
        self.scale = self.scale or prior_stiffness_scale(self.model.tolerance)
        self._tables()
        self.state = FitState()

    @cached_property
    def _other(self) -> PoseFitter | None:
        """Fitter of the inverted branch; `None` if the twin lacks it."""
        other = self.model.marker_twin.twin.inverted
        return None if other is None else replace(self, model=self.model.on_branch(other))

    def _tables(self) -> None:
        """Predict the images of a grid of starting poses, and factor the covariance of the unit."""
        twin = self.model.marker_twin.twin
        first, last = twin.depths_mm[[0, -1]]
        depths = first + (last - first) * np.array([0.02, 0.05, 0.1, 0.3, 0.5, 0.7, 0.9])
        tilts = twin.tilts_deg[-1] * np.array([0.0, 0.35, 0.8])
        turns = np.radians(np.arange(0, 360, 45))
        self._starts = np.array(
            [
                (*rotation_vector(tilt, turn), depth)
                for depth in depths
                for tilt in tilts
                for turn in (turns if tilt else turns[:1])
            ]
        )
        slip = float(np.clip(self._mean["inverse_friction"], twin.inverse_frictions[0], twin.inverse_frictions[-1]))
        first = self.model.predict(self._starts[0], slip, unit=False)
        self._shown = np.array([self.model.predict(start, slip, near=first).pixels for start in self._starts])
        covariance = self.mounting.covariance if self.mounting else self.model.posterior.covariance
        self._unit_spread = np.linalg.cholesky(covariance + 1e-18 * np.eye(len(covariance)))

    def fit(self, seen_px: FloatArray) -> PoseFit:
        """Fit one image, and keep the state for the next; for `seen_px` see `follow`."""
        found, self.state = self.follow(seen_px, self.state)
        return found

    def follow(self, seen_px: FloatArray, state: FitState, near: PoseFit | None = None) -> tuple[PoseFit, FitState]:
        """Fit the image after a state; if the misfit is too large, try the second branch.

        `seen_px` (m, 2) are the markers in the order of the layout, NaN if not detected; `near` is a fit of almost
        the same markers, from which this fit starts. Returns the fit, and the state after this image.
        """
        inverted = self._other is not None and (state.inverted if near is None else near.inverted)
        found, state = self._fit_branch(seen_px, state, inverted, None if near is None else near.state)
        if found.misfit > _DOUBTED and self._other is not None:
            again, state = self._fit_branch(seen_px, state, not inverted)
            if again.cost < found.cost:
                found, inverted = again, not inverted
        return self._of_other(found) if inverted else found, replace(state, inverted=inverted)

    def _fit_branch(
        self, seen_px: FloatArray, state: FitState, inverted: bool, begin: State | None = None
    ) -> tuple[PoseFit, FitState]:
        """Fit one image on one branch of the skin; return the fit, and the state with this branch updated."""
        if inverted and self._other is not None:
            found, branch = self._other._fit_near(seen_px, state.other, begin)
            return found, replace(state, other=branch)
        found, branch = self._fit_near(seen_px, state.flat, begin)
        return found, replace(state, flat=branch)

    def positions(self, found: PoseFit) -> FloatArray:
        """Return the fitted marker positions (m, 3) mm in the skin's frame; NaN if not visible at rest."""
        model = self._model_of(found)
        contact = found.state
        moved = model.marker_twin.evaluate(
            contact[POSE],
            contact["inverse_friction"],
            model.posterior.mean["thickness"],
            contact[LATERAL] if self._drifts else None,
            contact["curvature"],
        )
        return np.where(model.visible[:, None], moved.positions, np.nan)

    def _model_of(self, found: PoseFit) -> UnitModel:
        """Return the model of the branch of a fit."""
        return (self._other if found.inverted and self._other else self).model

    def predict_pixels(self, found: PoseFit) -> FloatArray:
        """Return the fitted markers (m, 2) px; NaN if not visible at rest."""
        model = self._model_of(found)
        looked = model.predict_contact(found.state, lateral=self._drifts)
        assert looked.unit_jacobian is not None
        return looked.pixels + looked.unit_jacobian @ found.unit

    def _of_other(self, found: PoseFit) -> PoseFit:
        """Mark a fit as inverted, with the prior of 1/µ: the inverted branch does not depend on friction."""
        friction = ScalarEstimate(self._mean["inverse_friction"], self._sd["inverse_friction"])
        return replace(found, inverted=True, inverse_friction=friction)

    def _fit_near(
        self, seen_px: FloatArray, state: BranchState, begin: State | None = None
    ) -> tuple[PoseFit, BranchState]:
        """Fit one image from the extrapolated contact, if in doubt from others too; return the next state."""
        if begin is None:
            begin = self._begin(seen_px) if state.last is None else self._go_on(seen_px, state.last, state.motion)
        found, near = self._fit(seen_px, begin, state.near)
        if state.last is not None and self._doubted(found, state.last):
            again, near = self._fit(seen_px, self._begin(seen_px), near)
            found = again if again.cost < found.cost else found
        if self._at_limit(found.state["inverse_friction"]):
            usual = found.state.replace(inverse_friction=self._mean["inverse_friction"])
            again, near = self._fit(seen_px, usual, near)
            found = again if again.cost < found.cost else found
        return found, state.after(found.state, near, self._near)

    def _go_on(self, seen_px: FloatArray, last: State, motion: State) -> State:
        """Extrapolate the last contact; at shallow depth, start from the pose table if that is more similar."""
        onward = self._inside(last + motion)
        if last["depth_mm"] > _SHALLOW_MM * self._size:
            return onward
        shown = self.model.predict_contact(onward, lateral=False, unit=False).pixels
        away = np.nansum((np.append(self._shown, shown[None], axis=0) - seen_px) ** 2, axis=(1, 2))
        return onward if int(away.argmin()) == len(self._starts) else self._begin(seen_px)

    def _doubted(self, found: PoseFit, last: State) -> bool:
        """Test whether a fit that started from the last contact may have reached a wrong minimum."""
        return found.misfit > _DOUBTED or abs(found.state["curvature"] - last["curvature"]) > _OTHER_WALL / self._size

    def _at_limit(self, inverse_friction: float) -> bool:
        """Test whether 1/µ is at an end of the twin's range, where a fit may be trapped.

        The cost has a second minimum there: markers at µ = 1 resemble those without slip more than those at µ = 3.
        """
        return self._slips[0] < self._slips[1] and not self._slips[0] < inverse_friction < self._slips[1]

    def _begin(self, seen_px: FloatArray) -> State:
        """Return the starting pose whose predicted image is most similar, with the prior mean of 1/µ."""
        away = np.nansum((self._shown - seen_px) ** 2, axis=(1, 2))
        return self._mean.add(POSE, self._starts[int(away.argmin())])

    def _look(self, contact: State, known: Linear | None) -> tuple[PredictedImage, Linear]:
        """Predict the image of a contact; reuse the linearisation in the unit if it is from a contact nearby."""
        if known is not None and (np.abs((contact - known[0]).values) > self._near.values).any():
            known = None
        near = known[1] if known else None
        looked = self.model.predict_contact(contact, lateral=self._drifts, near=near)
        if known is None:
            assert looked.unit_jacobian is not None
            known = contact, looked, looked.unit_jacobian @ self._unit_spread[: len(UNIT_PARAMETERS)]
        return looked, known

    def _fit(self, seen_px: FloatArray, begin: State, near: Linear | None) -> tuple[PoseFit, Linear]:
        """Fit one image from a starting contact; return the fit and the last linearisation."""
        free, known = self._free, len(self._free)
        contact = self._inside(begin)
        there = np.isfinite(seen_px).all(axis=1) & self.model.visible
        z = np.zeros(self._unit_spread.shape[1])
        mean, prior, gain = self._mean[free], self._sd[free] ** -2.0, np.inf
        bent, most, moved = "curvature" in free, 1.0, np.zeros(len(free) + len(z))
        least = 0.0 if bent else _GAINED
        for step in range(1, (_BENT_STEPS if bent else _STEPS) + 1):
            looked, near = self._look(contact, near)
            by_unit = near[2][there].reshape(-1, len(z))
            left = (seen_px - looked.pixels)[there].reshape(-1) - by_unit @ z
            weight = robust_weights(left, self._variance)
            jacobian = np.hstack([looked.pose_jacobian[free][there].reshape(-1, known), by_unit])
            weighted = jacobian * weight[:, None]
            normal = weighted.T @ jacobian
            normal[np.diag_indices(len(normal))] += np.concatenate([prior, np.ones(len(z))])
            gradient = weighted.T @ left
            gradient[:known] -= prior * (contact[free] - mean)
            gradient[known:] -= z
            change = self._solve(normal, gradient, contact)
            gain, last = float(gradient @ change), gain
            if gain > 0.5 * last and float(gradient @ moved) < 0:  # it swings, as about a corner of the twin over 1/µ
                most *= 0.5
            shrink = min(most, float(np.min(self._trust[free] / np.maximum(np.abs(change[:known]), 1e-12))))
            before, moved = contact, shrink * change
            contact = self._inside(contact.add(free, moved[:known]))
            z = z + moved[known:]
            still = (np.abs((contact - before).values) < self._small.values).all()
            if step >= 2 and (most * gain < least or still):
                break
        whole = np.asarray(np.linalg.inv(normal), float)
        pose, covariance = self._on_robot(contact, z, whole)
        assert near is not None
        bend_sd = float(np.sqrt(whole[free.index("curvature"), free.index("curvature")])) if bent else 0.0
        sd = np.sqrt(np.diag(covariance))
        found = PoseFit(
            pose,
            LEVEL_90 * sd[:3],
            covariance=covariance[:3, :3],
            inverse_friction=ScalarEstimate(contact["inverse_friction"], float(sd[READ.index("inverse_friction")])),
            curvature=ScalarEstimate(contact["curvature"], bend_sd),
            force=self._force(looked, contact, whole),
            residual_px=float(np.sqrt(np.mean(left**2))),
            misfit=float(np.mean(left**2) / self._variance * len(left) / max(len(left) - len(normal), 1)),
            steps=step,
            state=contact,
            cost=float(0.5 * (np.minimum(left**2 / self._variance, _OUTLIER).sum() + z @ z)),
            unit=(self._unit_spread @ z)[: len(UNIT_PARAMETERS)],
        )
        return found, near

    def _solve(self, normal: FloatArray, gradient: FloatArray, contact: State) -> FloatArray:
        """Solve for the Gauss-Newton step, with 1/µ constrained to the range of the twin."""
        change: FloatArray = np.asarray(np.linalg.solve(normal, gradient), float)
        for column in (place for place, name in enumerate(self._free) if name == "inverse_friction"):
            slip = contact["inverse_friction"] + change[column]
            held = min(max(slip, self._slips[0]), self._slips[1]) - contact["inverse_friction"]
            if held != change[column]:
                others = np.delete(np.arange(len(change)), column)
                pull = gradient[others] - normal[others, column] * held
                change[others], change[column] = np.linalg.solve(normal[np.ix_(others, others)], pull), held
        return change

    def _force(self, looked: PredictedImage, contact: State, whole: FloatArray) -> Force:
        """Return the contact force and its covariance, from the covariance of all parameters."""
        assert self.scale is not None
        by_thickness = self._unit_spread[len(UNIT_PARAMETERS) - 1]
        by_all = np.hstack([looked.force_jacobian[self._free], np.outer(looked.force_by_thickness, by_thickness)])
        vector, covariance = scale_force(looked.force, by_all @ whole @ by_all.T, self.scale)
        return Force(vector, covariance, wall_normal(*np.radians(contact[POSE[:2]])))

    def _on_robot(self, contact: State, z: FloatArray, whole: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the pose (3,), and the covariance (4, 4) of pose and 1/µ with the twin error."""
        by, free = np.zeros((len(READ), len(whole))), len(self._free)
        for column, name in enumerate(self._free):
            if name in READ:
                by[READ.index(name), column] = 1.0
        pose = contact[POSE]
        if self.mounting is not None:
            mounting = self._unit_spread[len(UNIT_PARAMETERS) :]
            by[:2, :2] = self.mounting.turn
            by[:3, free:] = self.mounting.jacobian(pose) @ mounting
            pose = self.mounting.to_robot(pose, mounting @ z)
        off = twin_sd(self.model.marker_twin.twin.skin)
        off = off.replace(inverse_friction=_LATERAL_FRICTION_SD) if self._drifts else off
        return pose, by @ whole @ by.T + np.diag(off[READ] ** 2)

    def _inside(self, contact: State) -> State:
        """Clip a contact to the range of the twin and the permitted extrapolation."""
        twin = self.model.marker_twin.twin
        rx, ry, depth = contact[POSE]
        tilt, most = float(np.hypot(rx, ry)), float(twin.tilts_deg[-1]) + _BEYOND[0]
        share = most / tilt if tilt > most else 1.0
        return contact.replace(
            rx_deg=share * rx,
            ry_deg=share * ry,
            depth_mm=np.clip(depth, twin.depths_mm[0], twin.depths_mm[-1] + _BEYOND[1] * self._size),
            inverse_friction=np.clip(contact["inverse_friction"], *self._slips),
        )


def twin_sd(skin: Skin) -> State:
    """Return the standard deviation of the error of a twin of a skin, in pose (degrees, mm) and 1/µ."""
    return scale_contact(TWIN_ERROR_SD, skin)


def contact_prior_sd(tolerance: ToleranceSpec) -> State:
    """Return the prior standard deviations of `CONTACT_STATE`; 0 for entries that the tolerance excludes."""
    pose = dict(zip(POSE, (TILT_SD_DEG, TILT_SD_DEG, _DEPTH_SD), strict=True))
    others = {"inverse_friction": tolerance.inverse_friction_prior[1], "curvature": tolerance.curvature_sd}
    return State.from_mapping(pose | others | dict(zip(LATERAL, tolerance.lateral_sd, strict=True)))


def free_entries(sd: State, twin: Twin) -> tuple[str, ...]:
    """Return the fitted entries of `CONTACT_STATE`: those that vary, 1/µ only if the twin has several."""
    several = len(twin.inverse_frictions) > 1
    return tuple(name for name in sd.names if sd[name] > 0 and (several or name != "inverse_friction"))
