"""Where the untouched dots are now: a camera creeps, silicone warms, and all dots move with them.

How far the dots have moved since the images at rest is split, image by image, into a motion of the camera (its place,
its turn, and its focal length, which is what swelling looks like) and what light touches do to this unit (the main
directions of its twin's touches, `_TOUCHES`):

    moved = C c + T t + noise

Only c is ever followed, so a light touch, held for however long, goes to t and is not learnt as rest. An image counts
as untouched where t explains nothing beyond the noise, and nothing else is left over. Then the rest follows a small
difference of c, each combination of the camera's numbers as far as the dots know it (`DriftFilter`); a large one that
is no noise is a knock. Few dots tell some motions of the camera from touches badly: 37 dots show one of 0.09 px rms
where nothing moved.
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
"""Numbers of the camera that may drift, and a step of each (mm, degrees, 1) of some tenths of a pixel."""
_LENGTHS = ("offset_x", "offset_y", "distance")
"""Those that are mm, for a skin of the size in `palpate.calibration.scale`, as the depths of the touches are."""
_TOUCHES = ((0.05, 0.15, 0.35, 0.7), (0.0, 5.0, 10.0), 8)
"""Depths (mm), tilts (degrees) and number of directions of the touches that are kept apart from drift."""
_MOST_STEPS = 10.0
"""How many of these steps a camera is moved at most, about: 1 mm or 2°. More would explain a touch by a camera."""
_LOST_PX = 0.01
"""What is left out of any touch, px rms."""
_SEEN_PX = 0.002
"""Motion that a step of a combination of the camera's numbers must make at rest to be kept, px rms."""
_KNOCK_PX = 0.15
"""Difference of the rest from what was followed above which it is a knock, px rms."""
_SURE = 5.0
"""Standard deviations above which a touch or a knock is seen."""
_NOISY_PX = 0.1
"""What may be left over of an untouched image at least, px rms of a coordinate."""
_LOUDER = 1.5
"""Variance of the dots' noise over the least that any image had: that of an image of a deep touch is no noise."""
_NOTHING_PX = 0.01
"""Motion of the rest below which dots are taken as they are, px rms."""


class RestDrift(NamedTuple):
    """How the untouched dots have moved as a whole since the images at rest.

    Attributes
    ----------
    rms_px
        Root mean square distance of the dots from where they were.
    shift_px
        Column and row by which their middle moved.
    turn_deg
        Turn about it, from columns to rows.
    scale
        By which they spread, 1 where they did not.
    """

    rms_px: float
    shift_px: tuple[float, float]
    turn_deg: float
    scale: float

    def summary(self) -> str:
        """What a person reads."""
        across, down = self.shift_px
        return (
            f"The untouched dots drifted by {self.rms_px:.2f} px rms: {across:+.2f}, {down:+.2f} px, turned by "
            f"{self.turn_deg:+.3f}°, spread by {100 * (self.scale - 1):+.2f} %. Poses are as if they had not."
        )


_STILL = RestDrift(0.0, (0.0, 0.0), 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class RestState:
    """What is known of one unit's rest after some images.

    Attributes
    ----------
    drift
        How far the camera has drifted.
    quiet
        Least variance of the dots' noise of any image, px².
    displaced
        Whether the last untouched image was elsewhere.
    motion
        What is followed so far.
    time_s
        When the last image was taken that was followed; `None` where no clock told it, or none was followed.
    """

    drift: CameraDrift
    quiet: float = np.inf
    displaced: bool = False
    motion: RestDrift = _STILL
    time_s: float | None = None

    def step_s(self, time_s: float | None) -> float:
        """Time from the last image that was followed to another, s; without a clock that of the nominal rate."""
        if time_s is None or self.time_s is None or time_s < self.time_s:
            return FRAME_S
        return min(time_s - self.time_s, LONGEST_S)


@dataclass(eq=False)
class DriftTracker:
    """Follows the rest of one unit.

    Attributes
    ----------
    model
        The unit.
    rest_px
        (m, 2) dots in the images at rest; NaN where none was seen.
    noise_px
        Standard deviation of a dot's coordinate in one image.
    max_drift_px
        How far the rest is followed, px rms; 0 follows nothing.
    """

    model: UnitModel
    rest_px: FloatArray
    noise_px: float
    max_drift_px: float

    def __post_init__(self) -> None:
        self._known: BoolArray = np.isfinite(self.rest_px).all(axis=1) & self.model.visible
        slopes = self.model.shifted.jacobian(self.model.dots.places)
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
        """What is known before any image but those at rest."""
        return RestState(self._filter.initial())

    def _make_filter(self) -> DriftFilter:
        """Follows motions of the camera as far as the dots of one image tell them from touches."""
        ways = self._whole[0]
        camera = ways[:, : self._free]
        unknown = self.noise_px**2 * np.linalg.inv(self._normal(ways))[: self._free, : self._free]
        return DriftFilter(np.asarray(unknown, float), camera.T @ camera / self._known.sum())

    def _describe(self, followed: FloatArray) -> RestDrift:
        """What a motion (k,) of the camera is to the dots."""
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
        """Dots (m, 2) px where they would be had the rest not moved.

        The shift of a dot by a drift of the camera depends on its place: that of the contact of the last image
        (`palpate.calibration.CONTACT_STATE`), or that at rest.
        """
        if state.motion.rms_px < _NOTHING_PX:
            return seen_px
        followed = self._filter.motion(state.drift)
        if contact is None:
            return np.asarray(seen_px - self._ways[..., : self._free] @ followed)
        thicker = self.model.posterior.mean["thickness"]
        pose, slip = contact[TILT_SPACE.names], contact["inverse_friction"]
        points = self.model.dots.evaluate(pose, slip, thicker).positions
        return np.asarray(seen_px - self.model.shifted.jacobian(points) @ (self._mix @ followed))

    def update(self, state: RestState, seen_px: FloatArray, time_s: float | None = None) -> RestState:
        """Look at an image's dots (m, 2) px, NaN where none was seen: follow them, or find them `displaced`.

        `time_s` is when the image was taken; without it, images follow each other at the nominal rate.
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
        """Motion of the camera (k,) of an image whose dots have moved so (n, 2), `None` where the dome is touched.

        And the least variance of the dots' noise of any image so far.
        """
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
        """Weight of a camera's numbers against dots: a large motion is unlikely."""
        return 2.0 * (self.noise_px / _MOST_STEPS) ** 2

    def _normal(self, ways: FloatArray) -> FloatArray:
        """Normal matrix (k, k) of ways (2 n, k) in which the dots move, the camera's first."""
        hold = np.zeros(ways.shape[1])
        hold[: self._free] = self._hold
        return np.asarray(ways.T @ ways + np.diag(hold), float)

    def _solver(self, there: BoolArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Ways (2 n, k) in which the dots that are there move; what finds all shares, and those without touches."""
        ways = self._ways[there].reshape(-1, self._ways.shape[2])
        camera = ways[:, : self._free]
        both, alone = (np.linalg.solve(self._normal(part), part.T) for part in (ways, camera))
        return ways, both, alone

    def _touches(self) -> FloatArray:
        """Main directions (m, 2, k) of what light touches do, px."""
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
        """Root mean square distance of the dots from rest that a motion (k,) of the camera makes, px."""
        moved = self._ways[self._known][..., : self._free] @ move
        return float(np.sqrt(np.mean(np.sum(moved**2, axis=1))))
