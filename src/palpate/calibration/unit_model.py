"""A built unit under its camera: from pose and friction to the pixels of its dots, with all derivatives.

What is not as designed about a unit is a vector of named numbers (`UNIT_PARAMETERS`): where its camera is and what
its lens is, and how thick its wall is. Each has the workshop's tolerance as its prior. Dots are where the image at
rest shows them: a dot's place on the undeformed surface is where the ray of its pixel leaves that surface, whatever
was misprinted, stretched or turned. So a change of the camera moves the dots with it, and what remains uncertain is
what the rest image cannot tell: camera against print.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares

from palpate.calibration.camera_derivatives import CameraDerivatives, Projection, project_with_jacobian
from palpate.calibration.deviation import Deviation
from palpate.calibration.scale import size_scale
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
"""Numbers of a `Deviation` that are the camera's."""
UNIT_PARAMETERS = (*CAMERA_PARAMETERS, "thickness")
"""Numbers of a `Deviation` that a unit's images depend on, and are not known of it beforehand."""
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
"""The tolerance that needs a derivative of `palpate.surrogate.TWIN_DERIVATIVES`."""
_STEP_MM = 0.05
"""Distance of the dots beside a dot, between which its surroundings are taken as straight."""
_STEP = 0.02
"""Step of a difference by an unknown, over its standard deviation beforehand."""
_LEAST_SD = 1e-6
_CORNERS = 6
"""Corners of the polygons that stand for dots; centres of their traces are within 0.0015 px rms of those with 32."""
_FORGIVEN = 3.0
"""Standard deviations beyond which a misprint no longer pulls with its square."""


PRINT_SHIFT = ("print_shift_x", "print_shift_y")
"""Shift of the whole print, mm."""


def unit_prior_sd(tolerance: ToleranceSpec) -> FloatArray:
    """Standard deviations (11,) of `UNIT_PARAMETERS` before any image: even within the tolerances."""
    found = np.array([float(getattr(tolerance, _TOLERANCE[name])) for name in UNIT_PARAMETERS]) / np.sqrt(3.0)
    return np.maximum(found, _LEAST_SD)


def modelled_tolerance(twin: Twin, tolerance: ToleranceSpec) -> ToleranceSpec:
    """A tolerance without the deviations that a twin leaves out: they are not estimated."""
    return tolerance.model_copy(update={_LEFT_OUT[name]: 0.0 for name in twin.left_out})


@dataclass(frozen=True, eq=False)
class UnitPosterior:
    """What is known of a unit: the image at rest, and a normal distribution of what is not as designed.

    Attributes
    ----------
    nominal
        The camera as designed, or as calibrated.
    rest_px
        (m, 2) dots in the image at rest; NaN where none was seen.
    mean, covariance
        `UNIT_PARAMETERS`, and their covariance (11, 11).
    """

    nominal: CameraSpec
    rest_px: FloatArray
    mean: State
    covariance: FloatArray

    def camera(self, **changes: float) -> Camera:
        """The camera believed in, or one whose parameters of these names differ by `changes`."""
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
    """What the image at rest tells about a unit.

    Parameters
    ----------
    twin, layout
        Skin and print as designed.
    nominal
        The camera as designed or calibrated, about where it is.
    rest_px
        (m, 2) the layout's dots in the image; NaN where none was seen.
    tolerance
        How far the unit may be from its design.
    noise_px
        Standard deviation of a dot's coordinate.

    Returns
    -------
    UnitPosterior
        Maximum of the posterior, and its covariance there.
    """
    seen = np.isfinite(rest_px).all(axis=1)
    before = unit_prior_sd(modelled_tolerance(twin, tolerance))
    sd = np.concatenate(
        [before[: len(CAMERA_PARAMETERS)], np.full(2, max(tolerance.print_shift, _LEAST_SD) / np.sqrt(3.0))]
    )
    spread = _rest_spread(twin, nominal, tolerance, noise_px)
    printed = MarkerLayout(layout.positions[seen], layout.diameter)

    def miss(values: FloatArray) -> FloatArray:
        left = _at_rest(twin, printed, nominal, State(_REST, values)) - rest_px[seen]
        return np.concatenate([np.nan_to_num(left, nan=1e3).ravel() / spread, values / sd])

    fit = least_squares(miss, np.zeros(len(sd)), x_scale=sd, loss="huber", f_scale=_FORGIVEN)
    covariance = np.diag(before**2)  # an image at rest says nothing of the thickness
    camera = slice(len(CAMERA_PARAMETERS))
    covariance[camera, camera] = np.linalg.inv(fit.jac.T @ fit.jac)[camera, camera]
    mean = State(UNIT_PARAMETERS, np.append(State(_REST, fit.x)[CAMERA_PARAMETERS], 0.0))
    return UnitPosterior(nominal, rest_px, mean, covariance)


def rest_jacobian(
    twin: Twin, layout: MarkerLayout, camera: Camera, tolerance: ToleranceSpec, noise_px: float
) -> tuple[FloatArray, float]:
    """What the image at rest says of camera and print, dot by dot, where both are about as designed.

    Returns
    -------
    slopes
        (m, 2, 12) px over the numbers of `CAMERA_PARAMETERS`, and over the print's shift in x and y (mm).
    spread_px
        Standard deviation of a coordinate: noise and the misprint of single dots.
    """
    steps = np.append(_STEP * unit_prior_sd(tolerance)[: len(CAMERA_PARAMETERS)], [1e-3, 1e-3])
    found = np.empty((len(layout), 2, len(steps)))
    for k, step in enumerate(steps):
        away = step * np.eye(len(steps))[k]
        high, low = (_at_rest(twin, layout, camera.spec, State(_REST, side * away)) for side in (1, -1))
        found[..., k] = (high - low) / (2 * step)
    return found, _rest_spread(twin, camera.spec, tolerance, noise_px)


_REST = (*CAMERA_PARAMETERS, *PRINT_SHIFT)
"""Parameters of an image at rest."""


def _at_rest(twin: Twin, layout: MarkerLayout, nominal: CameraSpec, values: State) -> FloatArray:
    """Pixels (m, 2) of the layout where camera and print differ from the design by these values."""
    camera = build_camera(_camera_of(nominal, values))
    x, y = (layout.positions[:, :2] + values[PRINT_SHIFT]).T
    printed = twin.skin.inner_point(np.hypot(x, y), np.arctan2(y, x))
    return _traces(camera, twin, printed, layout.diameter)


def _rest_spread(twin: Twin, nominal: CameraSpec, tolerance: ToleranceSpec, noise_px: float) -> float:
    """Standard deviation of a coordinate at rest about its place in the layout, px."""
    scale = float(nominal.fx_px / (nominal.distance + twin.skin.height))
    return float(np.hypot(noise_px, scale * tolerance.marker_position / np.sqrt(3.0)))


def _traces(camera: Camera, twin: Twin, points: FloatArray, diameter: float) -> FloatArray:
    """Centres (n, 2) px of the traces of dots that lie on the undeformed surface."""
    return project_markers(camera, marker_outlines(twin.skin, points, diameter, _CORNERS)).centres


class PredictedImage(NamedTuple):
    """What a unit shows at one pose.

    Attributes
    ----------
    pixels
        (m, 2) px; NaN for a dot that was not seen at rest.
    pose_jacobian
        (m, 2, 5 or 8) px over the entries of a contact (`CONTACT_STATE`); its motion only if one is given.
    unit_jacobian
        (m, 2, 11) px over `UNIT_PARAMETERS`; `None` where it was not asked for.
    bias
        (m, 2) px from the trace of a dot's centre to the centre of its trace.
    force, force_jacobian
        (3,) N on the wall, and (3, 5 or 8) by the same.
    force_by_thickness
        (3,) N over a mm of thickness.
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
    """A unit ready to be looked at.

    Attributes
    ----------
    layout, tolerance
        Its print as designed, and how far it may be from its design.
    posterior
        What is known of it.
    camera
        The camera believed in.
    dots
        The twin of its print; a dot that was not seen is at its place in the layout.
    visible
        (m,) whether a dot was seen at rest.
    outlines
        The twin of the edges of dots: what is seen is the centre of a trace, which is not the trace of the centre,
        above all where the skin bends.
    place_by
        (m, 3, 10) mm: how the dots move on the undeformed surface as the camera changes.
    tangent_waves
        Derivative of the print's waves along two tangents, and the part of `place_by` along each (m, 10).
    shifted
        Cameras beside the one believed in.
    """

    layout: MarkerLayout
    tolerance: ToleranceSpec
    posterior: UnitPosterior
    camera: Camera
    dots: MarkerTwin
    visible: BoolArray
    outlines: MarkerTwin
    place_by: FloatArray
    tangent_waves: tuple[tuple[FloatArray, FloatArray], ...]
    shifted: CameraDerivatives

    def with_posterior(self, posterior: UnitPosterior) -> UnitModel:
        """The model of the same unit, of which something else is known."""
        return build_unit_model(self.dots.twin, self.layout, posterior, self.tolerance)

    def on_branch(self, twin: Twin) -> UnitModel:
        """The model of the same unit on another branch."""
        return build_unit_model(twin, self.layout, self.posterior, self.tolerance)

    @property
    def size(self) -> float:
        """How many times as great the skin is as that of the constants (`palpate.calibration.scale`)."""
        return size_scale(self.dots.twin.skin)

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
        """Pixels of the dots at rx, ry (degrees) and depth (mm), under a friction of 1/µ = `inverse_friction`.

        `lateral` (3,) is how far the wall travelled in its plane (mm) and turned (degrees) on the way, and
        `curvature` its curvature, 1/m. With `unit`, also the derivatives by what is not known of the unit. These and
        the bias of traces change little from pose to pose: they are those of a look at one that is `near`, where that
        is given.
        """
        moved = self.dots.evaluate(pose, inverse_friction, self.posterior.mean["thickness"], lateral, curvature)
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
        """`predict` for a contact (`CONTACT_STATE`), with its motion in the plane of the wall if `lateral`."""
        motion = contact[LATERAL] if lateral else None
        pose, slip = contact[TILT_SPACE.names], contact["inverse_friction"]
        return self.predict(pose, slip, motion, contact["curvature"], unit=unit, near=near)

    def _by_unit(self, moved: MarkerState, shown: Projection, by_thickness: FloatArray) -> FloatArray:
        """Derivatives (m, 2, 11) px by `UNIT_PARAMETERS`; a camera that changes takes the places of the dots
        along."""
        carried = self.place_by.copy()
        for waves, along in self.tangent_waves:
            carried += (waves @ moved.amplitudes).reshape(-1, 3)[:, :, None] * along[:, None, :]
        return np.dstack([self.shifted.jacobian(moved.positions, shown, carried), by_thickness])

    def _bias(self, amplitudes: FloatArray, pixels: FloatArray) -> FloatArray:
        """From the traces of centres (m, 2) px to the centres of traces, where the waves have amplitudes (2 r,)."""
        edges = self.outlines.positions_at(amplitudes).reshape(len(pixels), -1, 3)
        return np.asarray(project_markers(self.camera, edges).centres - pixels)


def build_unit_model(
    twin: Twin, layout: MarkerLayout, posterior: UnitPosterior, tolerance: ToleranceSpec
) -> UnitModel:
    """Make the model of a unit from what is known of it."""
    skin, camera, tolerance = twin.skin, posterior.camera(), modelled_tolerance(twin, tolerance)
    steps = _STEP * unit_prior_sd(tolerance)
    seen: BoolArray = np.asarray(np.isfinite(posterior.rest_px).all(axis=1), dtype=np.bool_)
    about = np.where(
        seen[:, None], _places(camera, twin, posterior.rest_px, np.zeros_like(posterior.rest_px)), np.nan
    )
    about = np.where(np.isfinite(about), about, layout.positions)
    bias = _traces(camera, twin, about, layout.diameter) - camera.project(about)
    places = _places(camera, twin, posterior.rest_px, bias)
    seen = np.logical_and(seen, np.isfinite(places).all(axis=1))
    places = np.where(seen[:, None], places, layout.positions)
    rates, shifted = np.zeros((len(places), 3, len(CAMERA_PARAMETERS))), []
    for k in range(len(CAMERA_PARAMETERS)):
        name = CAMERA_PARAMETERS[k]
        pair = posterior.camera(**{name: steps[k]}), posterior.camera(**{name: -steps[k]})
        high, low = (_places(each, twin, posterior.rest_px, bias) for each in pair)
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
    """Where the rays of dots (m, 2) px leave the undeformed inner surface, (m, 3) mm; NaN where there is none."""
    known = np.isfinite(pixels).all(axis=1)
    places = np.full((len(pixels), 3), np.nan)
    places[known] = twin.skin.hit(*camera.sight_lines(pixels[known] - bias[known]))
    return places
