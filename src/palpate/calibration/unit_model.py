"""Image model of a built unit: from pose and friction to the pixels of its markers, with derivatives.

The deviations of a unit are a vector of parameters (`UNIT_PARAMETERS`): pose and lens of its camera, and skin
thickness. Their prior is given by the manufacturing tolerances. The position of a marker on the undeformed surface is
where the ray of its pixel in the rest image meets that surface, which includes misprints, stretch and rotation. A
change of the camera therefore moves the markers too. The remaining uncertainty is that between camera and print,
which the rest image cannot separate.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares

from palpate.calibration.camera_derivatives import CameraDerivatives, Projection, project_with_jacobian
from palpate.calibration.deviation import Deviation
from palpate.calibration.tolerance import ToleranceSpec
from palpate.camera import Camera, CameraSpec, build_camera, marker_outlines, project_markers
from palpate.core import BoolArray, FloatArray
from palpate.core.state import State
from palpate.design import TILT_SPACE, MarkerLayout
from palpate.surrogate import LATERAL, MarkerState, MarkerTwin, Twin

CAMERA_PARAMETERS = (
    "offset_x",
    "offset_y",
    "distance",
    "tilt_x_deg",
    "tilt_y_deg",
    "roll_deg",
    "focal",
    "centre_x_px",
    "centre_y_px",
    "k1",
)
"""Fields of `Deviation` that describe the camera."""
UNIT_PARAMETERS = (*CAMERA_PARAMETERS, "thickness")
"""Fields of `Deviation` that change a unit's images and are unknown before its first image."""
_TOLERANCE = {
    "offset_x": "camera_offset",
    "offset_y": "camera_offset",
    "distance": "camera_distance",
    "tilt_x_deg": "camera_tilt_deg",
    "tilt_y_deg": "camera_tilt_deg",
    "roll_deg": "camera_roll_deg",
    "focal": "focal",
    "centre_x_px": "centre_px",
    "centre_y_px": "centre_px",
    "k1": "distortion",
    "thickness": "thickness",
}
_LEFT_OUT = {
    "thickness": "thickness",
    "curvature": "curvature",
    "lateral_rate": "lateral",
    "lateral_rate_across": "lateral",
    "twist_rate_deg": "twist_deg",
}
"""Tolerance that requires each derivative of `palpate.surrogate.TWIN_DERIVATIVES`."""
_STEP_MM = 0.05
"""Step along a tangent for derivatives by the marker position, mm. By hand."""
_STEP = 0.02
"""Step for derivatives by a parameter, over its prior standard deviation. By hand."""
LEAST_SD = 1e-6
"""Minimum prior standard deviation: a parameter without tolerance keeps a finite weight."""
_CORNERS = 6
"""Corners of a marker's polygon; its projected centroid is within 0.0015 px rms of that with 32."""
_FORGIVEN = 3.0
"""Residual of a misprint, in standard deviations, above which its cost is linear. By hand."""


PRINT_SHIFT = ("print_shift_x", "print_shift_y")
"""Displacement of the whole print, mm."""


def unit_prior_sd(tolerance: ToleranceSpec) -> FloatArray:
    """Return the prior standard deviations (11,) of `UNIT_PARAMETERS`: uniform within the tolerances."""
    found = np.array([float(getattr(tolerance, _TOLERANCE[name])) for name in UNIT_PARAMETERS]) / np.sqrt(3.0)
    return np.maximum(found, LEAST_SD)


def modelled_tolerance(twin: Twin, tolerance: ToleranceSpec) -> ToleranceSpec:
    """Return a tolerance without the deviations that a twin does not model; they are not estimated."""
    return tolerance.model_copy(update={_LEFT_OUT[name]: 0.0 for name in twin.left_out})


@dataclass(frozen=True, eq=False)
class UnitPosterior:
    """Rest image of a unit, and the normal distribution of its parameters.

    Attributes
    ----------
    nominal
        Camera as designed or calibrated.
    rest_px
        (m, 2) markers in the rest image; NaN for a marker that was not detected.
    mean, covariance
        `UNIT_PARAMETERS`, and their covariance (11, 11).
    """

    nominal: CameraSpec
    rest_px: FloatArray
    mean: State
    covariance: FloatArray

    def camera(self, **changes: float) -> Camera:
        """Return the mean camera, with `changes` added to its parameters."""
        mean = self.mean.add(tuple(changes), np.array(list(changes.values()), float))
        return build_camera(_camera_of(self.nominal, mean))


def _camera_of(nominal: CameraSpec, values: State) -> CameraSpec:
    named: dict[str, Any] = {name: values[name] for name in CAMERA_PARAMETERS}
    return Deviation(**named).camera(nominal)


def infer_from_rest(
    twin: Twin,
    layout: MarkerLayout,
    nominal: CameraSpec,
    rest_px: FloatArray,
    tolerance: ToleranceSpec,
    noise_px: float,
) -> UnitPosterior:
    """Infer the unit parameters from the rest image.

    Parameters
    ----------
    twin, layout
        Skin and layout as designed.
    nominal
        Camera as designed or calibrated, at its approximate pose.
    rest_px
        (m, 2) the layout's markers in the image; NaN for a marker that was not detected.
    tolerance
        Tolerances of the unit.
    noise_px
        Standard deviation of a marker coordinate.

    Returns
    -------
    UnitPosterior
        Maximum of the posterior, and its covariance there.
    """
    seen = np.isfinite(rest_px).all(axis=1)
    before = unit_prior_sd(modelled_tolerance(twin, tolerance))
    sd = np.concatenate(
        [before[: len(CAMERA_PARAMETERS)], np.full(2, max(tolerance.print_shift, LEAST_SD) / np.sqrt(3.0))]
    )
    spread = _rest_spread(twin, nominal, tolerance, noise_px)
    printed = MarkerLayout(layout.positions[seen], layout.diameter)

    def miss(values: FloatArray) -> FloatArray:
        left = _at_rest(nominal, state := State(_REST, values), _printed(twin, printed, state)) - rest_px[seen]
        return np.concatenate([np.nan_to_num(left, nan=1e3).ravel() / spread, values / sd])

    def slopes(values: FloatArray) -> FloatArray:
        found = _rest_slopes(twin, printed, nominal, values, _STEP * sd) / spread
        return np.concatenate([np.nan_to_num(found).reshape(-1, len(sd)), np.diag(1 / sd)])

    fit = least_squares(miss, np.zeros(len(sd)), slopes, x_scale=sd, loss="huber", f_scale=_FORGIVEN)
    covariance = np.diag(before**2)  # an image at rest says nothing of the thickness
    camera = slice(len(CAMERA_PARAMETERS))
    covariance[camera, camera] = np.linalg.inv(fit.jac.T @ fit.jac)[camera, camera]
    mean = State(UNIT_PARAMETERS, np.append(State(_REST, fit.x)[CAMERA_PARAMETERS], 0.0))
    return UnitPosterior(nominal, rest_px, mean, covariance)


def rest_jacobian(
    twin: Twin, layout: MarkerLayout, camera: Camera, tolerance: ToleranceSpec, noise_px: float
) -> tuple[FloatArray, float]:
    """Compute the derivatives of each marker in the rest image by camera and print, at the nominal design.

    Returns
    -------
    slopes
        (m, 2, 12) px over `CAMERA_PARAMETERS`, and over the print shift in x and y (mm).
    spread_px
        Standard deviation of a coordinate: noise and misprint of single markers.
    """
    steps = np.append(_STEP * unit_prior_sd(tolerance)[: len(CAMERA_PARAMETERS)], [1e-3, 1e-3])
    found = _rest_slopes(twin, layout, camera.spec, np.zeros(len(steps)), steps)
    return found, _rest_spread(twin, camera.spec, tolerance, noise_px)


def _rest_slopes(
    twin: Twin, layout: MarkerLayout, nominal: CameraSpec, values: FloatArray, steps: FloatArray
) -> FloatArray:
    """Return derivatives (m, 2, 12) px of a rest image about values (12,), by central differences."""
    found, printed = np.empty((len(layout), 2, len(steps))), _printed(twin, layout, State(_REST, values))
    for k, away in enumerate(np.diag(steps)):
        own = k >= len(CAMERA_PARAMETERS)  # the camera does not move the print
        moved = (State(_REST, values + side * away) for side in (1, -1))
        high, low = (_at_rest(nominal, one, _printed(twin, layout, one) if own else printed) for one in moved)
        found[..., k] = (high - low) / (2 * steps[k])
    return found


_REST = (*CAMERA_PARAMETERS, *PRINT_SHIFT)
"""Parameters of a rest image."""


def _at_rest(nominal: CameraSpec, values: State, edges: FloatArray) -> FloatArray:
    """Return pixels (m, 2) of printed outlines if the camera deviates from the design by these values."""
    return project_markers(build_camera(_camera_of(nominal, values)), edges).centres


def _printed(twin: Twin, layout: MarkerLayout, values: State) -> FloatArray:
    """Return the outlines (m, k, 3) mm of the layout whose print is shifted."""
    x, y = (layout.positions[:, :2] + values[PRINT_SHIFT]).T
    points = twin.skin.inner_point(np.hypot(x, y), np.arctan2(y, x))
    return marker_outlines(twin.skin, points, layout.diameter, _CORNERS)


def _rest_spread(twin: Twin, nominal: CameraSpec, tolerance: ToleranceSpec, noise_px: float) -> float:
    """Return the standard deviation of a marker coordinate at rest about its layout position, px."""
    scale = float(nominal.fx_px / (nominal.distance + twin.skin.height))
    return float(np.hypot(noise_px, scale * tolerance.marker_position / np.sqrt(3.0)))


class PredictedImage(NamedTuple):
    """Predicted image of a unit at one pose.

    Attributes
    ----------
    pixels
        (m, 2) px; NaN for a marker that was not visible at rest.
    pose_jacobian
        (m, 2, 5 or 8) px over the entries of a contact (`CONTACT_STATE`); lateral motion only if it is given.
    unit_jacobian
        (m, 2, 11) px over `UNIT_PARAMETERS`; `None` if not requested.
    bias
        (m, 2) px from the projected centre of a marker to the centroid of its projected outline.
    force, force_jacobian
        (3,) N on the wall, and its derivatives (3, 5 or 8) by the contact.
    force_by_thickness
        (3,) N per mm of thickness.
    """

    pixels: FloatArray
    pose_jacobian: State
    unit_jacobian: FloatArray | None
    bias: FloatArray
    force: FloatArray
    force_jacobian: State
    force_by_thickness: FloatArray


@dataclass(frozen=True, eq=False)
class UnitModel:
    """Image model of a unit.

    Attributes
    ----------
    layout, tolerance
        Layout as designed, and tolerances.
    posterior
        Distribution of its parameters.
    camera
        Camera at the posterior mean.
    marker_twin, visible
        Twin of its markers, and whether each (m,) was detected at rest; if not, it is at its layout position.
    outlines
        Twin of the marker outlines. The detector measures the centroid of a projected outline, which differs from the
        projected centre, above all where the skin is strongly curved.
    place_by
        (m, 3, 10) mm, derivative of the marker positions on the undeformed surface by the camera.
    tangent_waves
        Derivative of the twin's waves along two tangents, and the component of `place_by` along each (m, 10).
    shifted
        Derivatives of pixels by the camera.
    """

    layout: MarkerLayout
    tolerance: ToleranceSpec
    posterior: UnitPosterior
    camera: Camera
    marker_twin: MarkerTwin
    visible: BoolArray
    outlines: MarkerTwin
    place_by: FloatArray
    tangent_waves: tuple[tuple[FloatArray, FloatArray], ...]
    shifted: CameraDerivatives

    def with_posterior(self, posterior: UnitPosterior) -> UnitModel:
        """Return the model of this unit with another posterior."""
        return build_unit_model(self.marker_twin.twin, self.layout, posterior, self.tolerance)

    def on_branch(self, twin: Twin) -> UnitModel:
        """Return the model of this unit on another branch."""
        return build_unit_model(twin, self.layout, self.posterior, self.tolerance)

    @property
    def size(self) -> float:
        """Size of the skin relative to that of the constants (`palpate.calibration.scale`)."""
        return self.marker_twin.twin.skin.size

    def predict(
        self,
        pose: FloatArray,
        inverse_friction: float,
        lateral: FloatArray | None = None,
        curvature: float = 0.0,
        *,
        unit: bool = True,
        near: PredictedImage | None = None,
    ) -> PredictedImage:
        """Predict the image at rx, ry (degrees) and depth (mm), with 1/µ = `inverse_friction`.

        `lateral` (3,) is the lateral motion (mm) and twist (degrees) of the wall during the press, and `curvature`
        its curvature, 1/m. With `unit`, the derivatives by the unit parameters are computed too. They and the bias of
        the outlines change little with the pose, so they are taken from `near`, if that is given.
        """
        moved = self.marker_twin.evaluate(
            pose, inverse_friction, self.posterior.mean["thickness"], lateral, curvature
        )
        pixels, slopes = shown = project_with_jacobian(self.camera, moved.positions)
        by_all = State(moved.jacobian.names, slopes @ moved.jacobian.values)
        by_thickness = by_all["thickness"]
        if near is not None:
            by_unit, bias = near.unit_jacobian, near.bias
        else:
            by_unit = self._by_unit(moved, shown, by_thickness) if unit else None
            bias = self._bias(moved.amplitudes, pixels)
        pixels = np.where(self.visible[:, None], pixels + bias, np.nan)
        contact = tuple(name for name in by_all.names if name != "thickness")
        by_pose, by_force = (State(contact, each[contact]) for each in (by_all, moved.force_jacobian))
        return PredictedImage(
            pixels, by_pose, by_unit, bias, moved.force, by_force, moved.force_jacobian["thickness"]
        )

    def predict_contact(
        self, contact: State, *, lateral: bool, unit: bool = True, near: PredictedImage | None = None
    ) -> PredictedImage:
        """Predict the image of a contact (`CONTACT_STATE`), with its lateral motion if `lateral`."""
        motion = contact[LATERAL] if lateral else None
        pose, slip = contact[TILT_SPACE.names], contact["inverse_friction"]
        return self.predict(pose, slip, motion, contact["curvature"], unit=unit, near=near)

    def _by_unit(self, moved: MarkerState, shown: Projection, by_thickness: FloatArray) -> FloatArray:
        """Return the derivatives (m, 2, 11) px by `UNIT_PARAMETERS`; the camera also moves the markers."""
        carried = self.place_by.copy()
        for waves, along in self.tangent_waves:
            carried += (waves @ moved.amplitudes).reshape(-1, 3)[:, :, None] * along[:, None, :]
        return np.dstack([self.shifted.jacobian(moved.positions, shown, carried), by_thickness])

    def _bias(self, amplitudes: FloatArray, pixels: FloatArray) -> FloatArray:
        """Return the bias (m, 2) px of the outlines for amplitudes (2 r,) of the waves."""
        edges = self.outlines.positions_at(amplitudes).reshape(len(pixels), -1, 3)
        return np.asarray(project_markers(self.camera, edges).centres - pixels)


def build_unit_model(
    twin: Twin, layout: MarkerLayout, posterior: UnitPosterior, tolerance: ToleranceSpec
) -> UnitModel:
    """Build the image model of a unit from its posterior."""
    skin, camera, tolerance = twin.skin, posterior.camera(), modelled_tolerance(twin, tolerance)
    rest_px, steps = posterior.rest_px, _STEP * unit_prior_sd(tolerance)
    seen: BoolArray = np.asarray(np.isfinite(rest_px).all(axis=1), dtype=np.bool_)
    about = np.where(seen[:, None], _places(camera, twin, rest_px, np.zeros_like(rest_px)), np.nan)
    about = np.where(np.isfinite(about), about, layout.positions)
    edges = marker_outlines(skin, about, layout.diameter, _CORNERS)
    bias = project_markers(camera, edges).centres - camera.project(about)
    places = _places(camera, twin, rest_px, bias)
    seen = np.logical_and(seen, np.isfinite(places).all(axis=1))
    places = np.where(seen[:, None], places, layout.positions)
    rates, shifted = np.zeros((len(places), 3, len(CAMERA_PARAMETERS))), []
    for k, name in enumerate(CAMERA_PARAMETERS):
        pair = posterior.camera(**{name: steps[k]}), posterior.camera(**{name: -steps[k]})
        high, low = (_places(each, twin, rest_px, bias) for each in pair)
        rates[..., k] = np.nan_to_num((high - low) / (2 * steps[k]))
        shifted.append(pair)
    _, along, around = skin.tangents(places)
    beside = []
    for tangent in (along, around):
        high, low = (twin.with_markers(skin.nearest(places + side * _STEP_MM * tangent)).waves for side in (1, -1))
        beside.append(((high - low) / (2 * _STEP_MM), np.einsum("mi,mik->mk", tangent, rates)))
    return UnitModel(
        layout,
        tolerance,
        posterior,
        camera,
        twin.with_markers(places),
        seen,
        twin.with_markers(marker_outlines(skin, places, layout.diameter, _CORNERS).reshape(-1, 3)),
        rates,
        tuple(beside),
        CameraDerivatives(camera, shifted, steps),
    )


def _places(camera: Camera, twin: Twin, pixels: FloatArray, bias: FloatArray) -> FloatArray:
    """Return where the rays of markers (m, 2) px meet the undeformed inner surface, (m, 3) mm, or NaN."""
    known = np.isfinite(pixels).all(axis=1)
    places = np.full((len(pixels), 3), np.nan)
    places[known] = twin.skin.hit(*camera.sight_lines(pixels[known] - bias[known]))
    return places
