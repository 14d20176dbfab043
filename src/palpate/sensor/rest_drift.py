"""Tracking of the unloaded markers: camera drift and thermal expansion move all of them.

In each image, the displacement of the markers since the rest images is split into a motion of the camera (position,
rotation, and focal length, which has the effect of swelling) and the effect of light contacts on this unit (principal
directions of its twin, `_TOUCHES`):

    moved = C c + T t + noise

Only c is tracked, so that a light contact of any duration contributes to t and not to the rest. An image counts as
unloaded if t is not significant and the residual is no more than noise. Then the rest follows a small change of c, in
each combination of the camera parameters that the markers determine (`DriftFilter`); a large, significant change is a
jump. Few markers distinguish some camera motions from contacts badly: 37 markers show a motion of 0.09 px rms of a
still camera.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from palpate.calibration import UNIT_PARAMETERS, UnitModel
from palpate.core import BoolArray, FloatArray
from palpate.core.state import State
from palpate.design import TILT_SPACE, rotation_vector
from palpate.sensor.drift_filter import FRAME_S, LONGEST_S, CameraDrift, DriftFilter

_CAMERA = UNIT_PARAMETERS[:-1]
_MOVES = {
    "offset_x": 0.1,
    "offset_y": 0.1,
    "distance": 0.1,
    "tilt_x_deg": 0.2,
    "tilt_y_deg": 0.2,
    "roll_deg": 0.2,
    "focal": 0.003,
    "centre_x_px": 0.5,
    "centre_y_px": 0.5,
}
"""Camera parameters that may drift, and a step of each (mm, degrees, 1) of some tenths of a pixel.
By hand."""
_LENGTHS = ("offset_x", "offset_y", "distance")
"""Parameters in mm, for a skin of the size in `palpate.calibration.scale`, as are the depths below."""
_TOUCHES = ((0.05, 0.15, 0.35, 0.7), (0.0, 5.0, 10.0), 8)
"""Depths (mm), tilts (degrees) and number of azimuths of contacts distinguished from drift. By hand."""
_MOST_STEPS = 10.0
"""Approximate maximum camera motion in steps of `_MOVES`: 1 mm or 2°; larger ones mimic contacts.
By hand."""
_LOST_PX = 0.01
"""Maximum part of a contact that its principal directions may omit, px rms. By hand."""
_SEEN_PX = 0.002
"""Minimum motion at rest per step of a tracked combination of parameters, px rms. By hand."""
_KNOCK_PX = 0.15
"""Deviation from the tracked rest above which the camera has jumped, px rms. By hand."""
_SURE = 5.0
"""Standard deviations above which a contact or a jump is significant. By hand."""
_NOISY_PX = 0.1
"""Residual of an unloaded image that is accepted in any case, px rms of a coordinate. By hand."""
_LOUDER = 1.5
"""Factor on the minimum noise variance of images: residuals of deep contacts are no noise. By hand."""
_NOTHING_PX = 0.01
"""Drift below which it is not removed from marker positions, px rms. By hand."""


class RestDrift(NamedTuple):
    """Common motion of the unloaded markers since the rest images.

    Attributes
    ----------
    rms_px, shift_px
        Root mean square displacement of the markers, and shift of their centre (column, row).
    turn_deg, scale
        Rotation about the centre, from columns to rows, and scale factor, 1 if unchanged.
    """

    rms_px: float
    shift_px: tuple[float, float]
    turn_deg: float
    scale: float

    def summary(self) -> str:
        """Return a sentence for display."""
        across, down = self.shift_px
        return (
            f"The unloaded markers drifted by {self.rms_px:.2f} px rms: {across:+.2f}, {down:+.2f} px, rotated by "
            f"{self.turn_deg:+.3f}°, scaled by {100 * (self.scale - 1):+.2f} %. Poses are corrected for it."
        )


_STILL = RestDrift(0.0, (0.0, 0.0), 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class RestState:
    """State of the drift tracking of one unit.

    Attributes
    ----------
    drift, motion
        State of the drift filter, and the tracked drift.
    quiet
        Minimum noise variance of a marker coordinate over all images, px².
    displaced
        Whether the last unloaded image contradicted the tracked rest.
    time_s
        Time of the last tracked image; `None` without a clock or a tracked image.
    """

    drift: CameraDrift
    quiet: float = np.inf
    displaced: bool = False
    motion: RestDrift = _STILL
    time_s: float | None = None

    def step_s(self, time_s: float | None) -> float:
        """Return the time since the last tracked image, s; without a clock, that of the nominal rate."""
        if time_s is None or self.time_s is None or time_s < self.time_s:
            return FRAME_S
        return min(time_s - self.time_s, LONGEST_S)


@dataclass(eq=False)
class DriftTracker:
    """Tracker of the rest of one unit.

    Attributes
    ----------
    model, rest_px
        The unit, and (m, 2) marker positions in the rest images; NaN if not found.
    noise_px, max_drift_px
        Standard deviation of a marker coordinate in one image; maximum drift that is tracked, px rms (0 tracks
        nothing).
    """

    model: UnitModel
    rest_px: FloatArray
    noise_px: float
    max_drift_px: float

    def __post_init__(self) -> None:
        self._known: BoolArray = np.isfinite(self.rest_px).all(axis=1) & self.model.visible
        slopes = self.model.shifted.jacobian(self.model.marker_twin.places)
        size = self.model.size
        steps = {name: step * (size if name in _LENGTHS else 1.0) for name, step in _MOVES.items()}
        moves = slopes[..., [_CAMERA.index(name) for name in steps]] * list(steps.values())
        _, sizes, mixed = np.linalg.svd(moves[self._known].reshape(-1, len(_MOVES)), full_matrices=False)
        kept = sizes > _SEEN_PX * np.sqrt(2 * self._known.sum())
        self._mix = np.zeros((len(_CAMERA), int(kept.sum())))
        for row, (name, step) in enumerate(steps.items()):
            self._mix[_CAMERA.index(name)] = step * mixed[kept, row]
        self._free = self._mix.shape[1]
        self._ways = np.concatenate([slopes @ self._mix, self._touches()], axis=2)
        self._whole = self._solver(self._known)
        self._filter = self._make_filter()

    def begin(self) -> RestState:
        """Return the state before any image but the rest images."""
        return RestState(self._filter.initial())

    def _make_filter(self) -> DriftFilter:
        """Build the filter of camera motions, with the accuracy of one image that may show a contact."""
        ways = self._whole[0]
        camera = ways[:, : self._free]
        unknown = self.noise_px**2 * np.linalg.inv(self._normal(ways))[: self._free, : self._free]
        return DriftFilter(np.asarray(unknown, float), camera.T @ camera / self._known.sum())

    def _describe(self, followed: FloatArray) -> RestDrift:
        """Describe the effect of a camera motion (k,) on the markers."""
        moved = (self._ways[..., : self._free] @ followed)[self._known]
        rest = self.rest_px[self._known] - self.rest_px[self._known].mean(axis=0)
        shift, size = moved.mean(axis=0), float(np.sum(rest**2))
        turn = float(np.sum(rest[:, 0] * moved[:, 1] - rest[:, 1] * moved[:, 0])) / size
        return RestDrift(
            self._rms(followed),
            (float(shift[0]), float(shift[1])),
            float(np.degrees(turn)),
            1.0 + float(np.sum(rest * moved)) / size,
        )

    def remove_drift(self, state: RestState, seen_px: FloatArray, contact: State | None = None) -> FloatArray:
        """Remove the drift from marker positions (m, 2) px.

        The shift of a marker by a camera drift depends on its position: that at the given contact
        (`palpate.calibration.CONTACT_STATE`), or that at rest.
        """
        if state.motion.rms_px < _NOTHING_PX:
            return seen_px
        followed = self._filter.motion(state.drift)
        if contact is None:
            return np.asarray(seen_px - self._ways[..., : self._free] @ followed)
        thicker = self.model.posterior.mean["thickness"]
        pose, slip = contact[TILT_SPACE.names], contact["inverse_friction"]
        points = self.model.marker_twin.evaluate(pose, slip, thicker).positions
        return np.asarray(seen_px - self.model.shifted.jacobian(points) @ (self._mix @ followed))

    def update(self, state: RestState, seen_px: FloatArray, time_s: float | None = None) -> RestState:
        """Update the state by the marker positions (m, 2) px of an image, NaN if not found.

        `time_s` is the time of the image; without it, images follow each other at the nominal rate.
        """
        there = self._known & np.isfinite(seen_px).all(axis=1)
        moved, quiet = self._camera_motion(there, (seen_px - self.rest_px)[there], state.quiet)
        state = replace(state, quiet=quiet)
        if moved is None:
            return state
        step_s = state.step_s(time_s)
        if self._filter.is_jump(state.drift, moved, step_s, _KNOCK_PX, _SURE):
            return replace(state, displaced=True)
        if self.max_drift_px <= 0:
            return replace(state, displaced=False)
        drift = self._filter.update(state.drift, moved, step_s)
        followed = self._filter.motion(drift)
        if self._rms(followed) > self.max_drift_px:
            return replace(state, displaced=True)
        return RestState(drift, quiet, False, self._describe(followed), time_s)

    def _camera_motion(self, there: BoolArray, moved: FloatArray, quiet: float) -> tuple[FloatArray | None, float]:
        """Return the camera motion (k,), `None` in contact, and the minimum noise variance of all images."""
        if 2 * len(moved) <= 2 * self._ways.shape[2]:
            return None, quiet
        ways, both, alone = self._whole if bool((there == self._known).all()) else self._solver(there)
        left = moved.ravel()
        found, camera = both @ left, alone @ left
        without = float(np.sum((left - ways[:, : self._free] @ camera) ** 2) + self._hold * np.sum(camera**2))
        within = float(np.sum((left - ways @ found) ** 2))
        held = within + self._hold * float(np.sum(found[: self._free] ** 2))
        free, touches = len(left) - ways.shape[1], ways.shape[1] - self._free
        quiet = min(quiet, within / free)
        variance = max(_LOUDER * quiet, 2.0 * self.noise_px**2)
        noisy = within / free > max(_NOISY_PX, 3.0 * self.noise_px) ** 2
        if noisy or (without - held) / variance > touches + _SURE * np.sqrt(2.0 * touches):
            return None, quiet
        return np.asarray(found[: self._free], float), quiet

    @property
    def _hold(self) -> float:
        """Weight of the prior on camera parameters: a large motion is unlikely."""
        return 2.0 * (self.noise_px / _MOST_STEPS) ** 2

    def _normal(self, ways: FloatArray) -> FloatArray:
        """Return the normal matrix (k, k) of the design matrix (2 n, k), whose first columns are the camera's."""
        hold = np.zeros(ways.shape[1])
        hold[: self._free] = self._hold
        return np.asarray(ways.T @ ways + np.diag(hold), float)

    def _solver(self, there: BoolArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the design matrix (2 n, k) of the found markers, and its solvers with and without contacts."""
        ways = self._ways[there].reshape(-1, self._ways.shape[2])
        camera = ways[:, : self._free]
        both, alone = (np.linalg.solve(self._normal(part), part.T) for part in (ways, camera))
        return ways, both, alone

    def _touches(self) -> FloatArray:
        """Return the principal directions (m, 2, k) of light contacts, px."""
        depths, tilts, turns = self.model.size * np.array(_TOUCHES[0]), *_TOUCHES[1:]
        slip = float(self.model.tolerance.inverse_friction_prior[0])
        rest = self.model.predict(np.zeros(3), slip, unit=False).pixels
        moved = []
        for tilt in tilts:
            for turn in np.arange(turns if tilt else 1) * (2.0 * np.pi / turns):
                poses = (np.append(rotation_vector(tilt, turn), depth) for depth in depths)
                moved += [self.model.predict(pose, slip, unit=False).pixels - rest for pose in poses]
        fields = np.where(self._known[:, None], np.array(moved), 0.0).reshape(len(moved), -1)
        _, sizes, ways = np.linalg.svd(fields, full_matrices=False)
        kept = sizes > _LOST_PX * np.sqrt(fields.shape[1])
        return np.ascontiguousarray(np.moveaxis(ways[kept].reshape(-1, len(self.rest_px), 2), 0, -1))

    def _rms(self, move: FloatArray) -> float:
        """Return the root mean square marker displacement at rest by a camera motion (k,), px."""
        moved = self._ways[self._known][..., : self._free] @ move
        return float(np.sqrt(np.mean(np.sum(moved**2, axis=1))))
