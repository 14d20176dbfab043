"""Pose estimators of a sensor: a trained network, or a fit of the unit's twin.

A network was trained for the nominal camera. A blob in the real image is projected along its ray to the height of its
marker at rest, or to the wall if that is lower, and from there into the nominal camera. The rest image is converted
in the same way, and the network reads its own rest positions plus the difference. This removes roll, tilt, focal
length and distortion of the real camera exactly, print and seating errors at rest, and an offset of the camera as far
as the skin follows the wall. The wall is that of a first estimate; for other obstacles only the heights at rest are
used.

A twin is fitted to the marker positions in the real camera (`palpate.calibration.fit_pose`).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from palpate.calibration import FitState, Force, PoseFit, PoseFitter, build_unit_model, infer_from_rest, predict_force
from palpate.core import FloatArray, PalpateError
from palpate.core.state import State
from palpate.design import TILT_SPACE, MarkerLayout, PoseSpace, Skin, wall_normal
from palpate.learn import Prediction, Predictor, is_recorded_model, open_predictor
from palpate.material import Relaxation
from palpate.sensor.reading import Flag, Reading
from palpate.sensor.rest_drift import DriftTracker, RestState
from palpate.sensor.spec import SensorSpec
from palpate.sensor.unit import Unit
from palpate.surrogate import Twin, read_twin, twin_path, twin_relaxation
from palpate.vision import MarkerAssignment, PrintDistortion, Registration, TrackedMarkers

_SAME_MM = 0.1
"""Camera offset below which the height of a marker does not matter: below 0.1 px at full depth."""

_NEAR = np.array([2.0, 2.0, 0.5])
"""Change of rx, ry (degrees) and depth (mm) within which the image shift by drift is constant."""

PoseModel = Predictor | Twin
"""Trained network or twin, by which a sensor reads."""


@dataclass(frozen=True, eq=False)
class ReaderState:
    """State carried from one image to the next; a network carries none.

    Attributes
    ----------
    rest, fit
        Drift of the markers since the rest images, and start of the next fit.
    contact
        `palpate.calibration.CONTACT_STATE` of the last image, if the fit explained it.
    """

    rest: RestState | None = None
    fit: FitState = field(default_factory=FitState)
    contact: State | None = None


class PoseEstimator(ABC):
    """Estimator of the pose from the assigned markers of one unit.

    Attributes
    ----------
    space
        Components of the pose.
    """

    space: PoseSpace

    @property
    def twin_fit(self) -> PoseFitter | None:
        """Fit of the unit's twin; `None` for a network."""
        return None

    @property
    def relaxation(self) -> Relaxation | None:
        """Relaxation of the force; `None` if unknown."""
        return None

    def begin(self) -> ReaderState:
        """Return the state before any image but the rest images."""
        return ReaderState()

    @abstractmethod
    def estimate(
        self,
        sighting: TrackedMarkers,
        state: ReaderState,
        near: Reading | None = None,
        time_s: float | None = None,
    ) -> tuple[Reading, ReaderState]:
        """Return the reading of the next image, by its tracked markers, and the next state.

        The sensor adds the number, the time and the markers of the image, and removes flags without contact.

        `near` is a reading of the same image by another assignment, a possible start; `time_s` is the time of the
        image, if known.
        """

    def predict_markers(self, estimate: Reading) -> FloatArray | None:
        """Return the positions (m, 2) px that an estimate predicts, NaN if hidden; `None` if not available."""
        return None


class NetworkEstimator(PoseEstimator):
    """Pose estimator by a trained network."""

    def __init__(
        self,
        predictor: Predictor,
        unit: Unit,
        naming: MarkerAssignment,
        registration: Registration,
        spec: SensorSpec,
    ) -> None:
        self.predictor, self.unit, self.space = predictor, unit, predictor.space
        self._touch_px = spec.touch_px
        self._camera = registration.camera
        self._nominal = unit.design.camera
        self._rest_model = self._nominal.project(unit.design.layout.positions)
        self._rest = self._carry(self._camera.sight_lines(naming.positions_px))
        self._same = bool(np.linalg.norm(self._camera.origin - self._nominal.origin) < _SAME_MM)

    def estimate(
        self,
        sighting: TrackedMarkers,
        state: ReaderState,
        near: Reading | None = None,
        time_s: float | None = None,
    ) -> tuple[Reading, ReaderState]:
        sight = self._camera.sight_lines(sighting.positions_px)
        moved = self._carry(sight) - self._rest
        prediction = self.predictor.predict((self._rest_model + moved)[None])
        if not self._same and self.space.is_tilt:
            # now that the wall is about known, so is how far the markers sank
            moved = self._carry(sight, prediction.pose[0]) - self._rest
            prediction = self.predictor.predict((self._rest_model + moved)[None])
        flags = (Flag.OUT_OF_DISTRIBUTION,) if prediction.out_of_distribution[0] else ()
        reading = Reading(
            pose=prediction.pose[0],
            half_width=prediction.half_width[0],
            space=self.space,
            touching=bool(np.sqrt(np.mean(moved**2)) > self._touch_px),
            flags=flags,
            force=self._force(prediction),
        )
        return reading, state

    def _force(self, prediction: Prediction) -> Force | None:
        """Return the force on the wall, for a unit of the design's stiffness within its tolerance."""
        if prediction.forces is None or prediction.forces_half_width is None:
            return None
        turn = Rotation.from_rotvec([*np.radians(prediction.pose[0, :2]), 0.0]).as_matrix()
        return predict_force(prediction.forces[0], prediction.forces_half_width[0], turn, self.unit.tolerance)

    def _carry(self, sight: tuple[FloatArray, FloatArray], pose: FloatArray | None = None) -> FloatArray:
        """Project blobs on rays of the real camera into the nominal camera, for a wall near this pose."""
        starts, rays = sight
        reach = (self.unit.design.layout.positions[:, 2] - starts[:, 2]) / rays[:, 2]
        if pose is not None:
            normal, limit = _wall(self.unit.design.skin, pose)
            to_wall = (limit - starts @ normal) / np.maximum(rays @ normal, 1e-3)
            reach = np.minimum(reach, to_wall)
        return self._nominal.project(starts + rays * reach[:, None])


def _as_printed(layout: MarkerLayout, law: PrintDistortion | None) -> MarkerLayout:
    """Return a layout with the positions of a print distortion, if there is one."""
    return layout if law is None else replace(layout, positions=law.positions)


class TwinEstimator(PoseEstimator):
    """Pose estimator by a fit of the unit's twin."""

    def __init__(
        self, twin: Twin, unit: Unit, naming: MarkerAssignment, spec: SensorSpec, law: PrintDistortion | None = None
    ) -> None:
        self.space = TILT_SPACE
        rest = np.where(naming.found[:, None], naming.positions_px, np.nan)
        calibrated = unit.camera_spec
        mounting, scale = None, None
        if unit.identified is None:
            belief = infer_from_rest(
                twin, _as_printed(unit.design.layout, law), calibrated, rest, unit.tolerance, spec.noise_px
            )
        else:
            belief, mounting = replace(unit.identified.posterior, rest_px=rest), unit.identified.mounting
            scale = unit.identified.scale
            _refuse_moved(unit.identified.posterior.rest_px, rest, spec.drift_px)
        model = build_unit_model(twin, unit.design.layout, belief, unit.tolerance)
        self.fitter = PoseFitter(model, spec.noise_px, mounting, scale)
        self.watch = DriftTracker(model, rest, spec.noise_px, spec.follow_px)
        self._rest, self._spec = rest, spec
        self._near = _NEAR * [1.0, 1.0, model.size]

    @property
    def twin_fit(self) -> PoseFitter | None:
        return self.fitter

    @property
    def relaxation(self) -> Relaxation | None:
        return twin_relaxation(self.fitter.model.marker_twin.twin)

    def begin(self) -> ReaderState:
        return ReaderState(self.watch.begin())

    def estimate(
        self,
        sighting: TrackedMarkers,
        state: ReaderState,
        near: Reading | None = None,
        time_s: float | None = None,
    ) -> tuple[Reading, ReaderState]:
        seen = np.where(sighting.found[:, None], sighting.positions_px, np.nan)
        rest = self.watch.update(state.rest or self.watch.begin(), seen, time_s)
        seen, fit, fitted = self._fit(seen, rest, state, near.fit if near else None)
        twin = self.fitter.model.marker_twin.twin
        flags = [Flag.CAMERA_MOVED] if rest.displaced else []
        if not ((fit.inverted and twin.inverted) or twin).covers(fit.state[TILT_SPACE.names]):
            flags.append(Flag.OUT_OF_DISTRIBUTION)
        if fit.misfit > self._spec.misfit:
            flags.append(Flag.MISFIT)
        contact = fit.state if fit.misfit <= self._spec.misfit and not fit.inverted else None
        reading = Reading(
            pose=fit.pose,
            half_width=fit.half_width,
            touching=bool(np.sqrt(np.nanmean((seen - self._rest) ** 2)) > self._spec.touch_px),
            flags=tuple(flags),
            force=fit.force,
            fit=fit,
            rest=rest.motion,
        )
        return reading, ReaderState(rest, fitted, contact)

    def predict_markers(self, estimate: Reading) -> FloatArray | None:
        return None if estimate.fit is None else self.fitter.predict_pixels(estimate.fit)

    def _fit(
        self, seen: FloatArray, rest: RestState, state: ReaderState, near: PoseFit | None
    ) -> tuple[FloatArray, PoseFit, FitState]:
        """Remove the drift from marker positions, fit them, and return both with the next state.

        If the contact is far from that of the last image, the drift is removed again, with the shift at this contact.
        """
        last = state.contact
        still = self.watch.remove_drift(rest, seen, last)
        fit, after = self.fitter.follow(still, state.fit, near)
        if still is not seen and (last is None or (np.abs((fit.state - last)[TILT_SPACE.names]) > self._near).any()):
            still = self.watch.remove_drift(rest, seen, fit.state)
            fit, after = self.fitter.follow(still, state.fit, fit)
        return still, fit, after


def _refuse_moved(before: FloatArray, now: FloatArray, most: float) -> None:
    """Raise an error if rest markers differ from those at identification: another unit, or a moved camera."""
    moved = float(np.nanmedian(np.linalg.norm(now - before, axis=1)))
    if not moved <= most:
        raise PalpateError(
            f"The rest markers are {moved:.2f} px from their positions at the identification of the unit.",
            "Identify the unit again: its camera has moved, or this is another unit.",
            code="rest-markers-moved",
        )


def make_estimator(
    model: PoseModel, unit: Unit, naming: MarkerAssignment, registration: Registration, spec: SensorSpec
) -> PoseEstimator:
    """Build the pose estimator of a unit from the assignment and registration of its rest image."""
    if isinstance(model, Twin):
        return TwinEstimator(model, unit, naming, spec, registration.distortion)
    return NetworkEstimator(model, unit, naming, registration, spec)


def open_model(path: Path, skin: Skin | None = None) -> PoseModel:
    """Open a pose model: a twin (``.h5``), a network (``.onnx``), or the twin in a result folder.

    Parameters
    ----------
    path
        The file or folder.
    skin
        Skin whose twin is searched in a folder.

    Raises
    ------
    PalpateError
        If the file is neither, or the folder has no twin of the skin.
    MissingExtraError
        If it is a network, and onnxruntime is not installed.
    """
    if path.is_dir() and skin is not None:
        return read_twin(_find_twin(path, skin))
    if path.suffix != ".h5":
        return open_predictor(path)
    if is_recorded_model(path):
        raise PalpateError(
            f"{path.name} was trained on a recording and has no design.",
            "Use it with palpate sensor live or palpate calibration accept.",
            code="model-no-design",
        )
    return read_twin(path)


def _find_twin(folder: Path, skin: Skin) -> Path:
    found = twin_path(folder, skin)
    if not found.is_file():
        raise PalpateError(
            f"{folder} has no twin of {skin.name}.",
            "Compute it by palpate calibration predict STUDY --out FOLDER, or give a file.",
            code="twin-missing",
        )
    return found


def check_model(model: PoseModel, unit: Unit, space: PoseSpace | None = None) -> None:
    """Raise a `PalpateError` if a model is of another design or estimates another pose."""
    if isinstance(model, Twin):
        if model.skin.spec_data != unit.design.skin.spec_data:
            raise PalpateError(
                f"The twin is of {model.skin.name}, but the design is {unit.design.skin.name}.",
                "Use the twin of this design.",
                code="twin-design-differs",
            )
        if unit.identified is not None:
            unit.identified.check(unit.design.skin, unit.design.layout)
        estimates = TILT_SPACE
    else:
        if unit.identified is not None:
            raise PalpateError(
                "A trained network cannot use an identified unit.",
                "Use the twin of the design (.h5) instead.",
                code="network-no-unit",
            )
        if model.markers != len(unit.design.layout):
            raise PalpateError(
                f"The model reads {model.markers} markers, but the design has {len(unit.design.layout)}.",
                "Use a model of this design.",
                code="model-marker-count",
            )
        estimates = model.space
    if space is not None and estimates != space:
        raise PalpateError(
            f"The model estimates {', '.join(estimates.names)}, not {', '.join(space.names)}.",
            "Use a model that was trained on presses of the same obstacle.",
            code="model-outputs-differ",
        )


def _wall(skin: Skin, pose: FloatArray) -> tuple[FloatArray, float]:
    """Return the wall normal n and the maximum n·x (mm) of the inner surface, at full skin thickness."""
    normal = wall_normal(*np.radians(pose[:2]))
    limit = skin.support_point(normal) @ normal - skin.thickness - max(float(pose[2]), 0.0) * normal[2]
    return normal, float(limit)
