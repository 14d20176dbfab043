"""Align a tool with a wall normal: press, read, rotate and repeat until the angle is within tolerance.

A press advances along the sensor's axis in steps until contact, then in two strides to the depth that force limit and
twin allow. An unreadable image is taken again. If all images at one depth are unreadable, the sensor steps back once,
and the last depth that was read counts if it is deep enough. The depth never increases without a readable image.

Let e be the measured angle between drill and normal, and C its covariance (reading, tool offset, robot). The tool is
square if |e| + q √λ(C) is within the tolerance. Before this test, the residual angle is corrected if that reduces it:
a rotation adds the robot's own error, so it is made only if |e|² > 2 σ².
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from palpate.core import FloatArray, PalpateError
from palpate.design import wall_normal
from palpate.sensor.alignment import Alignment, AlignmentOutcome, Touch
from palpate.sensor.force_limit import ForceLimit
from palpate.sensor.placement import Placement, rotation_between, rotation_from_vector, tilt_from_normal
from palpate.sensor.reading import Flag, Reading
from palpate.sensor.robot import Robot
from palpate.sensor.robot_spec import AlignSpec
from palpate.sensor.sensor import Sensor
from palpate.sensor.tool import Tool
from palpate.sensor.tool_offset import find_tool_offset

NextImage = Callable[[], "NDArray[Any] | PalpateError"]
"""Return an image taken after the call, or an error if none could be taken."""
_STRIDES, _ARRIVED_MM = (0.5, 1.0), 0.2
"""Shares of the remaining depth by which it is approached, and remaining depth at which it is reached.
By hand."""
_BACK_MM = 0.5
"""Retreat from the deepest image that was read, if the next one is not. By hand."""
_LIFT_MM, _MOST_LIFTS = 1.0, 4
"""Retreat after a touch that may be a camera motion, and maximum number of retreats. By hand."""
_LONGER = 1.5
"""Factor of the step that follows a press too light to be distinguished from a camera motion. By hand."""
_BEFORE_MM = 1.0
"""Distance from the last known wall position at which the next search begins. By hand."""
OFFSET_TURNS = tuple((60.0 * k, 3.0 * (-1) ** k) for k in range(6))
"""Default rotations (degrees) of `Aligner.find_offset`: about the drill's axis, and across it."""


class _Failed(Exception):  # noqa: N818  it carries an ending through a touch, and never leaves this file
    def __init__(self, ending: AlignmentOutcome) -> None:
        self.ending = ending


class Aligner:
    """Alignment of the tool of one robot with walls.

    Parameters
    ----------
    robot
        The robot; it starts in front of the wall, without contact.
    sensor
        Opened with the twin of its design.
    next_image
        Returns the next image.
    tool
        Poses of sensor and drill on the flange.
    spec
        Presses and stopping criteria.

    Raises
    ------
    PalpateError
        If the sensor does not read by a twin, or a step of the search could exceed the force limit.
    """

    def __init__(
        self, robot: Robot, sensor: Sensor, next_image: NextImage, tool: Tool, spec: AlignSpec | None = None
    ) -> None:
        fitter = sensor.estimator.twin_fit
        if fitter is None:
            raise PalpateError(
                "The force limit is computed from a twin, and this sensor reads by a trained network.",
                "Open the sensor with the design's twin.",
                code="network-no-force",
            )
        self.robot, self.sensor, self.tool, self.spec = robot, sensor, tool, spec or AlignSpec()
        self._next_image = next_image
        self._limit = ForceLimit(fitter, self.spec.force_n, self.spec.robot_mm)
        self._limit.check_step(_LONGER * self.spec.step)
        self._factor = float(np.sqrt(chi2.ppf(self.spec.level, 2)))
        self._images, self._gap = 0, 0.0
        skin = sensor.unit.design.skin
        self._apex = skin.support_point(np.array([0.0, 0.0, 1.0]))

    def align(self) -> Alignment:
        """Press and rotate until the tool is square; the flange ends clear of the wall.

        Raises
        ------
        PalpateError
            If the robot cannot reach a pose.
        """
        log = _Log()
        self._images = 0
        while len(log.touches) < self.spec.max_touches:
            try:
                touch = self.touch()
            except _Failed as failed:
                return log.end(failed.ending, np.zeros(2), np.inf, self._images)
            miss, covariance = self._miss(touch)
            error = 2.0 * self.spec.robot_deg**2
            turns = bool(miss @ miss > error)
            log.add(touch, float(np.hypot(*miss)), self._half_width(covariance), turns)
            left = np.zeros(2) if turns else miss
            own = self.spec.robot_deg**2 * np.eye(2) if turns else 0.0
            half = self._half_width(covariance + own)
            if turns:
                self._turn(touch)
            near = np.hypot(*miss) <= self.spec.near_deg and not touch.outside
            if near and np.hypot(*left) + half <= self.spec.tolerance_deg:
                return log.end(AlignmentOutcome.SQUARE, left, half, self._images)
        return log.end(AlignmentOutcome.TOO_MANY, left, half, self._images)

    def find_offset(self, turns: Sequence[tuple[float, float]] = OFFSET_TURNS) -> Tool:
        """Identify the sensor's rotation relative to the drill by presses of one wall.

        Parameters
        ----------
        turns
            Rotations (degrees) from the current flange pose, one press each: about the drill's axis, preferably all
            around, then about an axis across it, in both directions. Without the latter, the sensor's rotation about
            the drill stays unknown.

        Returns
        -------
        Tool
            The identified tool, which the aligner uses from now on.

        Raises
        ------
        PalpateError
            If a press fails, or the presses do not fit one wall.
        """
        touches, start = [], self.robot.flange_pose()
        across = np.linalg.svd(self.tool.drill[None])[2][1]
        for about, lean in turns:
            self._turn_to(
                start,
                start.rotation @ rotation_from_vector(about * self.tool.drill) @ rotation_from_vector(lean * across),
            )
            try:
                touches.append(self.touch())
            except _Failed as failed:
                raise PalpateError(
                    f"Touch {len(touches) + 1} of {len(turns)} failed: {failed.ending}.",
                    "Check the position of the wall, the light and the force limit.",
                    code="alignment-touch-failed",
                ) from None
        self._turn_to(start, start.rotation)
        self.tool = find_tool_offset(self.tool, touches, self.spec.robot_deg)
        return self.tool

    def touch(self) -> Touch:
        """Press the wall ahead once, and retract by `clear` mm."""
        start, before = self.robot.flange_pose(), self._images
        way = start.rotation @ self.tool.flange_from_sensor.rotation[:, 2]
        try:
            touch = self._press(start, way, *self._search(start, way))
        except _Failed:
            self.robot.move(start)
            raise
        self.robot.move(start.moved((touch.travel - touch.depth - self.spec.clear) * way))
        self._gap = self.spec.clear
        upper = self._limit.max_force(touch.fit.state, touch.depth)
        return replace(touch, force_upper_n=upper, images=self._images - before)

    def _search(self, start: Placement, way: FloatArray) -> tuple[float, Reading]:
        """Return the travel (mm) at the first image in contact, and its reading."""
        travel, lifts = max(self._gap - _BEFORE_MM, 0.0), 0
        self.robot.move(start.moved(travel * way))
        while travel <= self.spec.search:
            reading = self._look(Flag.OUT_OF_DISTRIBUTION, Flag.CAMERA_MOVED)
            if reading is None:
                raise _Failed(AlignmentOutcome.UNREADABLE)
            if Flag.CAMERA_MOVED in reading.flags:
                # the lightest of touches looks as if the camera had moved: above the wall that must be gone
                lifts += 1
                self._lift(start.moved((travel - _LIFT_MM) * way), lifts)
            elif reading.touching:
                return travel, reading
            travel += self.spec.step * (_LONGER if lifts else 1.0)
            self.robot.move(start.moved(travel * way))
        raise _Failed(AlignmentOutcome.NO_WALL)

    def _lift(self, place: Placement, lifts: int) -> None:
        """Retract, and fail if the markers stay displaced as by a camera motion."""
        self.robot.move(place)
        if self._look() is None or lifts > _MOST_LIFTS:
            raise _Failed(AlignmentOutcome.UNREADABLE)

    def _press(self, start: Placement, way: FloatArray, travel: float, reading: Reading) -> Touch:
        """Press to the allowed depth and return the deepest image that was read."""
        best = self._touch_of(travel, reading)
        for share in _STRIDES:
            left = self._limit.max_depth(best.fit, self.spec.depth) - best.depth
            if left < _ARRIVED_MM:
                break
            travel = best.travel + share * left
            self.robot.move(start.moved(travel * way))
            found = self._look(Flag.OUT_OF_DISTRIBUTION)
            if found is None or not found.touching:
                self.robot.move(start.moved((best.travel - _BACK_MM) * way))
                break
            best = self._touch_of(travel, found)
        if best.depth < self.spec.min_depth:
            raise _Failed(AlignmentOutcome.UNREADABLE if travel != best.travel else AlignmentOutcome.TOO_SHALLOW)
        return best

    def _look(self, *accepted: Flag) -> Reading | None:
        """Return a reading at this depth without other flags than those accepted; `None` if all images fail."""
        for _ in range(self.spec.max_image_retries):
            self._images += 1
            reading = self.sensor.read(self._next_image())
            if not set(reading.flags).difference(accepted):
                return reading
        return None

    def _touch_of(self, travel: float, reading: Reading) -> Touch:
        assert reading.fit is not None
        outside = Flag.OUT_OF_DISTRIBUTION in reading.flags
        return Touch(self.robot.flange_pose(), reading.fit, outside, travel)

    def _miss(self, touch: Touch) -> tuple[FloatArray, FloatArray]:
        """Return the rotation vector (2,) from drill to normal, z along the drill, and its covariance (2, 2)."""
        normal = wall_normal(*np.radians(touch.tilt_deg))
        drill = self.tool.drill_in_sensor
        to_drill = rotation_between(drill, np.array([0.0, 0.0, 1.0]))
        return tilt_from_normal(to_drill @ normal), touch.tilt_covariance + self.tool.covariance[:2, :2]

    def _half_width(self, covariance: FloatArray) -> float:
        return self._factor * float(np.sqrt(np.linalg.eigvalsh(covariance)[-1]))

    def _turn(self, touch: Touch) -> None:
        """Rotate the drill to the wall normal measured by a press."""
        flange = touch.base_from_flange.rotation
        normal = flange @ self.tool.flange_from_sensor.rotation @ wall_normal(*np.radians(touch.tilt_deg))
        here = self.robot.flange_pose()
        self._turn_to(here, rotation_between(flange @ self.tool.drill, normal) @ flange)

    def _turn_to(self, here: Placement, rotation: FloatArray) -> None:
        """Rotate the flange about the skin's apex."""
        apex = self.tool.flange_from_sensor.apply(self._apex)
        self.robot.move(Placement(rotation, here.apply(apex) - rotation @ apex))


class _Log:
    """Presses of an alignment so far."""

    def __init__(self) -> None:
        self.touches: list[Touch] = []
        self._rows: list[tuple[float, float, float]] = []

    def add(self, touch: Touch, angle: float, half: float, turns: bool) -> None:
        """Append a press, its measured angle, and whether the angle was corrected."""
        self.touches.append(touch)
        self._rows.append((angle, half, angle if turns else 0.0))

    def end(self, ending: AlignmentOutcome, left: FloatArray, half: float, images: int) -> Alignment:
        """Return the completed alignment."""
        angles, halves, turned = (tuple(row[column] for row in self._rows) for column in range(3))
        known = float(np.hypot(*left)) if np.isfinite(half) else float("nan")
        return Alignment(ending, tuple(self.touches), angles, halves, turned, known, half, images)
