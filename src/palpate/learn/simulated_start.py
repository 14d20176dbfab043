"""Start of a training from a simulation: displacements of a recording's markers by a twin.

The markers of the recording are placed on the skin by a lens: it maps the sorted distances of the design's markers
from the centre to those in the image at rest. Distance of the camera, frame of the poses and zero of the depth are
chosen to minimise the residual of the recorded presses.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.optimize import least_squares

from palpate.core import FloatArray, PalpateError, generator
from palpate.design import TILT_SPACE, Design
from palpate.learn.gaussian_process import train_process
from palpate.learn.member import MarkerProcess, MotionProcess
from palpate.learn.motion_model import HIDDEN_SD, add_simulation_error, draw_poses, estimate_hidden
from palpate.learn.prepare_recording import PreparedRecording
from palpate.learn.rotation import COUNT, RotationAugmentation, RotationOperators, tilt_vector
from palpate.learn.training_set import TrainingSet
from palpate.surrogate import MarkerTwin, Twin

_SURE = 0.9
"""Share of the markers that determine the lens, the central ones, and minimum seen at rest. By hand."""
_STEPS = 200
"""Points of the meridian. By hand."""


@dataclass(frozen=True, eq=False)
class SimulatedStart:
    """Simulation of a design.

    Attributes
    ----------
    name
        Its file.
    design
        The design, whose camera need not be that of the recording.
    twin
        Twin of its skin.
    """

    name: str
    design: Design
    twin: Twin

    def train(self, seen: PreparedRecording, samples: TrainingSet) -> MarkerProcess:
        """Estimator from the simulation and the training samples of a recording.

        Without training samples, poses count as in the frame of the image, and depths from first contact.

        Raises
        ------
        PalpateError
            If the recording has no rest image, other targets, other markers, or poses beyond the twin.
        """
        if seen.assigned is None or seen.assigned.reference < len(seen.recording):
            raise PalpateError(
                f"{self.name} simulates motion from rest, and the recording has no markers in an image at rest.",
                "Give the rest image by --rest, or train without --from.",
                code="start-needs-rest",
            )
        wanted = tuple(f"{one.axis}_{one.unit}" for one in seen.recording.poses)
        if wanted != TILT_SPACE.names:
            raise PalpateError(
                f"The targets are {', '.join(wanted)}; {self.name} simulates {', '.join(TILT_SPACE.names)}.",
                "Give a table with these, chosen by --targets, or train without --from.",
                code="start-outputs-differ",
            )
        self._refuse_beyond(seen)
        angles = seen.rotation.angles if seen.rotation is not None else "vector"
        rest_px = seen.assigned.layout.rest_px
        spacing = float(np.median(seen.assigned.layout.spacing_px))
        view = self._view(rest_px, self.design.camera_spec.distance)
        counts = len(rest_px), len(self.design.layout)
        if min(counts) < _SURE * max(counts) or view.misfit_px > 0.5 * spacing:
            raise PalpateError(
                f"The {counts[0]} markers at rest are not the {counts[1]} of {self.name}: the best lens maps their "
                f"distances from the centre to {view.misfit_px:.2g} px, with {spacing:.3g} px between markers.",
                "Give the study of this design, with its marker layout.",
                code="start-markers-differ",
            )
        if not samples.train.any():
            motion = _Motion(view, np.eye(2), 0.0, angles)
            poses = draw_poses(samples.targets, samples.seed)
            hidden = generator(samples.seed, "hidden").normal(size=poses.shape) * HIDDEN_SD / 2
            fields = motion.fields(poses, hidden).reshape(len(poses), -1, 2)
            fields = add_simulation_error(fields, rest_px, samples.seed)
            every = np.ones(len(poses), bool)
            drawn = TrainingSet(fields, poses, every, ~every, samples.seed, motion.symmetry)
            return MarkerProcess("simulation", train_process(drawn, doubtful=False))
        motion = self._identify(view, samples, angles)
        return MotionProcess.of_motion("simulation-motion", replace(samples, rotation=motion.symmetry), motion)

    def _refuse_beyond(self, seen: PreparedRecording) -> None:
        tilt = np.hypot(seen.targets[:, 0], seen.targets[:, 1])
        top, deep = float(self.twin.tilts_deg[-1]), float(self.twin.depths_mm[-1])
        if tilt.max() > top + 1.0 or seen.targets[:, 2].max() > deep + 1.0:
            raise PalpateError(
                f"The twin of {self.name} reaches {top:g}° and {deep:g} mm, the presses {tilt.max():.3g}° and "
                f"{seen.targets[:, 2].max():.3g} mm.",
                "Set tilts and depth of the study to these, and make its twin again.",
                code="start-beyond-twin",
            )

    def _view(self, rest_px: FloatArray, distance_mm: float) -> _View:
        """Markers of the twin where the recording shows them, under a camera at a distance below the base."""
        skin, middle = self.twin.skin, RotationOperators(rest_px).middle
        away = rest_px - middle
        radius, azimuth = np.linalg.norm(away, axis=1), np.arctan2(away[:, 1], away[:, 0])
        along = np.linspace(0.0, 1.0, _STEPS)
        meridian = skin.marked(np.column_stack([along, np.zeros(_STEPS)]))
        angle = np.arctan2(meridian[:, 0], meridian[:, 2] + distance_mm)
        designed = np.linalg.norm(skin.disc(self.design.layout.positions), axis=1)
        count = int(_SURE * min(len(radius), len(designed)))
        seen_at = np.interp(np.sort(designed)[:count], along, angle)
        shape = np.column_stack([np.tan(seen_at), seen_at])
        focal = np.linalg.lstsq(shape, np.sort(radius)[:count], rcond=None)[0]
        misfit = float(np.sqrt(np.mean((shape @ focal - np.sort(radius)[:count]) ** 2)))
        lens = np.column_stack([np.tan(angle), angle]) @ focal
        if (np.diff(lens) <= 0.0).any():
            focal, misfit = np.array([float(radius.max() / np.tan(angle[-1])), 0.0]), np.inf
            lens = focal[0] * np.tan(angle)
        place = np.interp(radius, lens, along)
        disc = place[:, None] * np.column_stack([np.cos(azimuth), np.sin(azimuth)])
        return _View(self.twin.with_markers(skin.marked(disc)), rest_px, middle, distance_mm, focal, misfit)

    def _identify(self, view: _View, samples: TrainingSet, angles: str) -> _Motion:
        """Frame, zero of depth and distance of the camera with the minimum residual of the training samples."""
        poses, fields = samples.targets[samples.train], samples.inputs[samples.train]
        fields = fields.reshape(len(fields), -1)
        mirrors, nominal = (np.eye(2), np.diag([1.0, -1.0])), self.design.camera_spec.distance

        def motion(values: FloatArray, mirror: FloatArray) -> _Motion:
            turn = np.array([[np.cos(values[0]), -np.sin(values[0])], [np.sin(values[0]), np.cos(values[0])]])
            distance = nominal * float(np.exp(values[2]))
            return _Motion(self._view(view.rest_px, distance), mirror @ turn, float(values[1]), angles)

        def residual(values: FloatArray, mirror: FloatArray) -> FloatArray:
            left = fields - motion(values, mirror).fields(poses)
            hidden = estimate_hidden(left, modes)
            return np.asarray((left - np.einsum("npk,nk->np", modes, hidden)).ravel())

        modes = np.zeros((*fields.shape, len(HIDDEN_SD)))
        zero = max(0.0, -float(poses[:, 2].min()))
        starts = [
            (np.array([2.0 * np.pi * number / COUNT, zero, 0.0]), mirror)
            for mirror in mirrors
            for number in range(COUNT)
        ]
        errors = [float(np.sum(residual(*one) ** 2)) for one in starts]
        begin, mirror = starts[int(np.argmin(errors))]
        modes = motion(begin, mirror).hidden_modes(poses)
        limit = np.array([np.inf, np.inf, 2.0 * np.log(2.0)])  # the camera is at most four times as far or near
        found = motion(least_squares(residual, begin, bounds=(-limit, limit), args=(mirror,)).x, mirror)
        left = np.linalg.norm(fields - found.fields(poses)) / max(float(np.linalg.norm(fields)), 1e-12)
        if left > 0.5:
            raise PalpateError(
                f"{self.name} does not explain how the markers move: {left:.0%} of their motion is left.",
                "Give the study of this sensor, and depths from first contact, or train without --from.",
                code="start-unsuitable",
            )
        return found


@dataclass(frozen=True, eq=False)
class _View:
    """Markers of a twin under a camera on the axis, whose radius in the image is focal · (tan θ, θ).

    Attributes
    ----------
    markers, rest_px
        Markers of the twin, and (m, 2) px where the recording shows them at rest.
    middle, distance_mm, focal
        (2,) px of the axis, distance below the base, and (2,) px of the two terms.
    misfit_px
        RMS residual of the sorted radii at rest.
    """

    markers: MarkerTwin
    rest_px: FloatArray
    middle: FloatArray
    distance_mm: float
    focal: FloatArray
    misfit_px: float

    def project(self, points: FloatArray) -> FloatArray:
        """Pixels (..., 2) of points (..., 3) mm."""
        away = np.hypot(points[..., 0], points[..., 1])
        angle = np.arctan2(away, points[..., 2] + self.distance_mm)
        radius = self.focal[0] * np.tan(angle) + self.focal[1] * angle
        return np.asarray(self.middle + points[..., :2] * (radius / np.maximum(away, 1e-9))[..., None])

    @cached_property
    def rest(self) -> FloatArray:
        """(m, 2) px of the undeformed markers."""
        return self.project(self.markers.places)


@dataclass(frozen=True, eq=False)
class _Motion:
    """Displacements of a recording's markers by a twin, see `palpate.learn.motion_model.SimulatedMotion`.

    Attributes
    ----------
    view
        The markers under the camera.
    frame
        (2, 2) rotation, or with a reflection, from tilts in the image's frame to those of the table.
    zero_mm
        Depth from first contact at which the table counts 0.
    angles
        Meaning of rx and ry, one of `palpate.learn.rotation.ANGLES`.
    """

    view: _View
    frame: FloatArray
    zero_mm: float
    angles: str

    @property
    def symmetry(self) -> RotationAugmentation:
        """Symmetry of the poses in the table's frame.

        A reflection of the image negates the rotation vector of the tilt along its axis, hence the quarter turn.
        """
        sense = 1 if np.linalg.det(self.frame) > 0 else -1
        turn = np.diag([1.0, sense]) @ self.frame
        angle = float(np.arctan2(turn[1, 0], turn[0, 0])) + 0.5 * np.pi
        base = np.zeros_like(self.view.rest_px)
        return RotationAugmentation(self.view.rest_px, base, sense, angle, self.angles)

    def fields(self, poses: FloatArray, hidden: FloatArray | None = None) -> FloatArray:
        tilts = tilt_vector(poses[:, :2], self.angles) @ self.frame
        depths = np.maximum(poses[:, 2] + self.zero_mm, 0.0)
        slip = 0.5 * float(self.view.markers.twin.inverse_frictions[-1])
        found = np.empty((len(poses), self.view.rest_px.size))
        for row, pose in enumerate(np.column_stack([tilts, depths])):
            lateral = None if hidden is None else hidden[row]
            state = self.view.markers.evaluate(pose, slip, lateral=lateral)
            found[row] = (self.view.project(state.positions) - self.view.rest).ravel()
        return found

    def hidden_modes(self, poses: FloatArray) -> FloatArray:
        still = self.fields(poses)
        moved = [self.fields(poses, np.tile(unit, (len(poses), 1))) for unit in np.eye(len(HIDDEN_SD))]
        return np.stack([each - still for each in moved], axis=2)
