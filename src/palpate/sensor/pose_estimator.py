"""What reads markers: a network that was trained, or a fit of the unit's twin.

A network was trained for the nominal camera. A dot seen by the real one is carried over the ray to the height of its
marker at rest, or to the wall where that is lower, and projected by the nominal camera; the same is done with the
rest image, and the network reads its own rest plus the difference. So roll, tilt, focal length and distortion of the
real camera are taken out exactly, print and seating errors at rest vanish, and an offset is taken out as far as the
dome follows the wall. The wall is that of a first estimate; of another obstacle only the heights at rest are used.

A twin is fitted to the dots as the real camera sees them (`palpate.calibration.fit_pose`).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from palpate.calibration import FitState, Force, PoseFit, PoseFitter, build_unit_model, infer_from_rest, predict_force
from palpate.core import FloatArray, PalpateError
from palpate.core.state import State
from palpate.design import TILT_SPACE, MarkerLayout, PoseSpace, Skin, wall_normal
from palpate.learn import Prediction, Predictor, is_recorded_model, open_predictor
from palpate.material import Relaxation
from palpate.sensor.reading import Flag
from palpate.sensor.rest_drift import DriftTracker, RestDrift, RestState
from palpate.sensor.spec import SensorSpec
from palpate.sensor.unit import Unit
from palpate.surrogate import Twin, read_twin, twin_path, twin_relaxation
from palpate.vision import MarkerAssignment, PrintDistortion, Registration, TrackedMarkers

_SAME_MM = 0.1
"""Offset of the camera below which the height of a marker does not matter: below 0.1 px at full depth."""

_NEAR = np.array([2.0, 2.0, 0.5])
"""Change of rx, ry (degrees) and depth (mm) within which a drift of the camera shows alike."""

PoseModel = Predictor | Twin
"""What a sensor reads with."""


class PoseEstimate(NamedTuple):
    """What a reader says about one image: pose, half-widths, motion (px rms), flags, force, fit and rest."""

    pose: FloatArray
    half_width: FloatArray
    moved_px: float
    flags: tuple[Flag, ...]
    force: Force | None = None
    fit: PoseFit | None = None
    rest: RestDrift | None = None


@dataclass(frozen=True, eq=False)
class ReaderState:
    """What a reader carries from one image to the next; a network carries nothing.

    Attributes
    ----------
    rest
        How far the untouched dots have drifted.
    fit
        From where the next image is fitted.
    contact
        `palpate.calibration.CONTACT_STATE` of the last image, if it was explained.
    """

    rest: RestState | None = None
    fit: FitState = field(default_factory=FitState)
    contact: State | None = None


class PoseEstimator(ABC):
    """Reads the named markers of one unit.

    Attributes
    ----------
    space
        What it estimates.
    """

    space: PoseSpace

    @property
    def twin_fit(self) -> PoseFitter | None:
        """What fits the unit's twin; `None` where a network reads."""
        return None

    @property
    def relaxation(self) -> Relaxation | None:
        """How the force fades under a touch that stays; `None` where nothing says so."""
        return None

    def begin(self) -> ReaderState:
        """The state before any image but those at rest."""
        return ReaderState()

    @abstractmethod
    def estimate(
        self,
        sighting: TrackedMarkers,
        state: ReaderState,
        near: PoseEstimate | None = None,
        time_s: float | None = None,
    ) -> tuple[PoseEstimate, ReaderState]:
        """Estimate the pose from where markers are in the image after a state; the estimate, and the next state.

        `near` is an estimate of the same image by other markers, from which this one may begin, and `time_s` when the
        image was taken, where a clock says so.
        """

    def predict_markers(self, estimate: PoseEstimate) -> FloatArray | None:
        """Dots (m, 2) px as an estimate has them, NaN where it has none; `None` where what reads does not know."""
        return None


class NetworkEstimator(PoseEstimator):
    """Reads by a trained network."""

    def __init__(
        self, predictor: Predictor, unit: Unit, naming: MarkerAssignment, registration: Registration
    ) -> None:
        self.predictor, self.unit, self.space = predictor, unit, predictor.space
        self._camera = registration.camera
        self._nominal = unit.design.camera
        self._rest_model = self._nominal.project(unit.design.layout.positions)
        self._rest = self._carry(self._camera.sight_lines(naming.positions_px))
        self._same = bool(np.linalg.norm(self._camera.origin - self._nominal.origin) < _SAME_MM)

    def estimate(
        self,
        sighting: TrackedMarkers,
        state: ReaderState,
        near: PoseEstimate | None = None,
        time_s: float | None = None,
    ) -> tuple[PoseEstimate, ReaderState]:
        sight = self._camera.sight_lines(sighting.positions_px)
        moved = self._carry(sight) - self._rest
        prediction = self.predictor.predict((self._rest_model + moved)[None])
        if not self._same and self.space.is_tilt:
            # now that the wall is about known, so is how far the markers sank
            moved = self._carry(sight, prediction.poses[0]) - self._rest
            prediction = self.predictor.predict((self._rest_model + moved)[None])
        flags = (Flag.OUT_OF_DISTRIBUTION,) if prediction.out_of_distribution[0] else ()
        moved_px = float(np.sqrt(np.mean(moved**2)))
        force = self._force(prediction)
        return PoseEstimate(prediction.poses[0], prediction.half_width[0], moved_px, flags, force), state

    def _force(self, prediction: Prediction) -> Force | None:
        """Force on the wall, of a unit that is as stiff as designed within its tolerance."""
        if prediction.forces is None or prediction.forces_half_width is None:
            return None
        turn = Rotation.from_rotvec([*np.radians(prediction.poses[0, :2]), 0.0]).as_matrix()
        return predict_force(prediction.forces[0], prediction.forces_half_width[0], turn, self.unit.tolerance)

    def _carry(self, sight: tuple[FloatArray, FloatArray], pose: FloatArray | None = None) -> FloatArray:
        """Dots on sights of the real camera as the nominal camera would show them, for a wall of about this pose."""
        starts, rays = sight
        reach = (self.unit.design.layout.positions[:, 2] - starts[:, 2]) / rays[:, 2]
        if pose is not None:
            normal, limit = _wall(self.unit.design.skin, pose)
            to_wall = (limit - starts @ normal) / np.maximum(rays @ normal, 1e-3)
            reach = np.minimum(reach, to_wall)
        return self._nominal.project(starts + rays * reach[:, None])


def _as_printed(layout: MarkerLayout, law: PrintDistortion | None) -> MarkerLayout:
    """A layout as designed, or where the law of its rings has it printed."""
    return layout if law is None else replace(layout, positions=law.positions)


class TwinEstimator(PoseEstimator):
    """Reads by fitting the unit's twin."""

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
        self._rest, self._most = rest, spec.misfit
        self._near = _NEAR * [1.0, 1.0, model.size]

    @property
    def twin_fit(self) -> PoseFitter | None:
        return self.fitter

    @property
    def relaxation(self) -> Relaxation | None:
        return twin_relaxation(self.fitter.model.dots.twin)

    def begin(self) -> ReaderState:
        return ReaderState(self.watch.begin())

    def estimate(
        self,
        sighting: TrackedMarkers,
        state: ReaderState,
        near: PoseEstimate | None = None,
        time_s: float | None = None,
    ) -> tuple[PoseEstimate, ReaderState]:
        seen = np.where(sighting.found[:, None], sighting.positions_px, np.nan)
        rest = self.watch.update(state.rest or self.watch.begin(), seen, time_s)
        seen, fit, fitted = self._fit(seen, rest, state, near and near.fit)
        twin = self.fitter.model.dots.twin
        flags = [Flag.CAMERA_MOVED] if rest.displaced else []
        if not ((fit.inverted and twin.inverted) or twin).covers(fit.state[TILT_SPACE.names]):
            flags.append(Flag.OUT_OF_DISTRIBUTION)
        if fit.misfit > self._most:
            flags.append(Flag.MISFIT)
        moved = float(np.sqrt(np.nanmean((seen - self._rest) ** 2)))
        contact = fit.state if fit.misfit <= self._most and not fit.inverted else None
        estimate = PoseEstimate(fit.pose, fit.half_width[:3], moved, tuple(flags), fit.force, fit, rest.motion)
        return estimate, ReaderState(rest, fitted, contact)

    def predict_markers(self, estimate: PoseEstimate) -> FloatArray | None:
        return None if estimate.fit is None else self.fitter.predict_pixels(estimate.fit)

    def _fit(
        self, seen: FloatArray, rest: RestState, state: ReaderState, near: PoseFit | None
    ) -> tuple[FloatArray, PoseFit, FitState]:
        """Dots as they were without drift, their fit, and the state after it.

        Where the contact is far from the last image's, drift is taken out once more, as it shows there.
        """
        last = state.contact
        still = self.watch.remove_drift(rest, seen, last)
        fit, after = self.fitter.follow(still, state.fit, near)
        if still is not seen and (last is None or (np.abs((fit.state - last)[TILT_SPACE.names]) > self._near).any()):
            still = self.watch.remove_drift(rest, seen, fit.state)
            fit, after = self.fitter.follow(still, state.fit, fit)
        return still, fit, after


def _refuse_moved(before: FloatArray, now: FloatArray, most: float) -> None:
    """Refuse a rest image that is not the one by which a unit is known: its camera has moved, or it is another."""
    moved = float(np.nanmedian(np.linalg.norm(now - before, axis=1)))
    if not moved <= most:
        raise PalpateError(
            f"The untouched dots are {moved:.2f} px from where they were when the unit was identified.",
            "Identify it again: its camera has moved, or this is another unit.",
            code="rest-markers-moved",
        )


def make_estimator(
    model: PoseModel, unit: Unit, naming: MarkerAssignment, registration: Registration, spec: SensorSpec
) -> PoseEstimator:
    """The reader of a unit whose rest image was named and registered."""
    if isinstance(model, Twin):
        return TwinEstimator(model, unit, naming, spec, registration.distortion)
    return NetworkEstimator(model, unit, naming, registration)


def open_model(path: Path, skin: Skin | None = None) -> PoseModel:
    """Open what reads a sensor of a known design: a twin (``.h5``), a network (``.onnx``), or a twin of a folder.

    Parameters
    ----------
    path
        The file, or a result folder.
    skin
        Whose twin is looked for in a folder.

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
            f"{path.name} was learnt from a recording and knows no design.",
            "Use it by palpate sensor live or palpate calibration accept.",
            code="model-no-design",
        )
    return read_twin(path)


def _find_twin(folder: Path, skin: Skin) -> Path:
    found = twin_path(folder, skin)
    if not found.is_file():
        raise PalpateError(
            f"{folder} has no twin of {skin.name}.",
            "Make it: palpate calibration predict STUDY --out FOLDER, or give a file.",
            code="twin-missing",
        )
    return found


def check_model(model: PoseModel, unit: Unit, space: PoseSpace | None = None) -> None:
    """Refuse a model of another design, or of another pose, with a `PalpateError`."""
    if isinstance(model, Twin):
        if model.skin.spec_data != unit.design.skin.spec_data:
            raise PalpateError(
                f"The twin is of {model.skin.name}, the design is {unit.design.skin.name}.",
                "Use its own twin.",
                code="twin-design-differs",
            )
        if unit.identified is not None:
            unit.identified.check(unit.design.skin, unit.design.layout)
        estimates = TILT_SPACE
    else:
        if unit.identified is not None:
            raise PalpateError(
                "A network cannot use what presses told about a unit.",
                "Read by the design's twin.",
                code="network-no-unit",
            )
        if model.markers != len(unit.design.layout):
            raise PalpateError(
                f"The model reads {model.markers} markers, the design has {len(unit.design.layout)}.",
                "Use the model of this design.",
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
    """Normal n of the wall and the greatest n·x of the inner surface beneath it, its thickness kept, mm."""
    normal = wall_normal(*np.radians(pose[:2]))
    limit = skin.support_point(normal) @ normal - skin.thickness - max(float(pose[2]), 0.0) * normal[2]
    return normal, float(limit)
