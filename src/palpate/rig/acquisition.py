"""Acquisition of a recording: rest images, and presses of one wall by a robot.

Each press starts clear of the wall and goes deeper along the sensor's axis; it waits, checks and writes an image at
every depth. After an interruption the acquisition resumes at the first image that has no row. After an error of the
camera the sensor is retracted along its axis; after an error of the robot, no further move is made.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from math import ceil
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, PalpateError
from palpate.core.run import Progress
from palpate.design import Rim, Skin, rotation_vector
from palpate.rig.check_image import NextImage, take_image
from palpate.rig.press_frame import PressFrame
from palpate.rig.recording_folder import RecordingFolder
from palpate.rig.take_spec import PlannedPress, TakeSpec
from palpate.sensor import Placement, Robot


class Acquisition:
    """Acquisition of one recording.

    Parameters
    ----------
    robot
        The robot. Before the first image, the upright skin just touches the wall, or almost.
    next_image
        Returns an image taken after the call.
    skin
        The skin.
    folder
        Images and table.
    spec
        Presses and timing.
    progress
        Receives the progress of the presses.

    Raises
    ------
    PalpateError
        If the wall would reach the clamped rim at a press, or the robot does not answer.
    """

    def __init__(
        self,
        robot: Robot,
        next_image: NextImage,
        skin: Skin,
        folder: RecordingFolder,
        spec: TakeSpec,
        progress: Progress | None = None,
    ) -> None:
        self._robot, self._next_image, self._spec = robot, next_image, spec
        self._folder, self._progress = folder, progress or Progress()
        self._before: NDArray[Any] | None = None
        self._lost = False
        tilt = np.radians(spec.max_tilt_deg)
        deepest = skin.clamp_depth(tilt, Rim.FLAT) if tilt < skin.rim_slope(Rim.FLAT) else 0.0
        if spec.depth >= deepest:
            raise PalpateError(
                f"At a tilt of {spec.max_tilt_deg:g}° the wall reaches the clamped rim at {deepest:.1f} mm, and the "
                f"last image is at {spec.depth:g} mm.",
                "Lower --depth or --max-tilt.",
                code="take-reaches-rim",
            )
        if "start" not in folder.plan:
            here = self._here()
            folder.write_plan(start={"rotation": here.rotation.tolist(), "position": here.position.tolist()})
        start = Placement(*(np.array(folder.plan["start"][name], float) for name in ("rotation", "position")))
        tool = Placement(position=np.array([0.0, 0.0, spec.tool_length]))
        self._frame = PressFrame(start, skin, tool)

    def take_rest(self) -> None:
        """Retract, and take the missing rest images."""
        names = [f"rest_{number:03d}.png" for number in range(self._spec.rest_images)]
        missing = [name for name in names if name not in self._folder]
        if missing:
            self._retract()
        for name in missing:
            time.sleep(self._spec.dwell_s)
            self._folder.add(name, take_image(self._next_image, None, self._spec))

    def take(self, count: int, choose: Callable[[int], PlannedPress]) -> None:
        """Take the missing images at rest and of all presses.

        Parameters
        ----------
        count
            Number of presses.
        choose
            Returns the press of a number, from 0; called once per press of a recording.

        Raises
        ------
        PalpateError
            If an image cannot be taken, the robot does not answer, or a file cannot be written.
        """
        self.take_rest()
        presses = self._folder.plan.setdefault("presses", [])
        self._progress.plan(count)
        try:
            for number in range(count):
                if number == len(presses):
                    self._folder.write_plan(presses=[*presses, list(choose(number))])
                    presses = self._folder.plan["presses"]
                self._press(number, *presses[number])
        except BaseException:
            if not self._lost:
                with suppress(PalpateError):
                    self._retract()
            raise

    def _press(self, number: int, tilt: float, azimuth: float) -> None:
        """Take the missing images of one press; the flange starts and ends clear of the wall."""
        label = f"press {number + 1}, {tilt:.2f}° about the axis at {azimuth:.1f}°"
        self._progress.begin(label)
        todo = [
            (name, depth)
            for image, depth in enumerate(self._spec.depths_mm)
            if (name := f"press_{number:03d}_{image:02d}.png") not in self._folder
        ]
        if todo:
            before = self._retract()
            tilted = np.append(rotation_vector(tilt, np.radians(azimuth)), -self._spec.clear)
            for share in np.linspace(0.0, 1.0, self._turns(before, tilted) + 1)[1:]:
                self._move(before + share * (tilted - before))
            for name, depth in todo:
                self._move(np.append(tilted[:2], depth))
                time.sleep(self._spec.dwell_s)
                self._before = take_image(self._next_image, self._before, self._spec)
                self._folder.add(name, self._before, str(number + 1), self._frame.pose_at(self._here()))
            self._retract()
        self._progress.finish(label)

    def _turns(self, before: FloatArray, after: FloatArray) -> int:
        """Number of moves between poses (3,) clear of the wall, each a straight line of the flange.

        On a line, a tool of length L that turns by an angle t comes nearer to the wall by up to L (1 - cos t/2).
        """
        spec, angle = self._spec, np.radians(np.hypot(*(after - before)[:2]))
        nearest = 1.0 - min(0.5 * spec.clear / max(spec.tool_length, spec.clear), 1.0)
        return max(ceil(0.5 * angle / np.arccos(nearest)), 1)

    def _here(self) -> Placement:
        self._lost = True
        here = self._robot.flange_pose()
        self._lost = False
        return here

    def _retract(self) -> FloatArray:
        """Move back along the sensor's axis until the skin is clear of the wall; return the pose (3,).

        Raises
        ------
        PalpateError
            If the sensor is tilted far from its start, or the robot does not answer.
        """
        here = self._here()
        pose = self._frame.pose_at(here)
        tilt, most = float(np.hypot(*pose[:2])), 2 * self._spec.max_tilt_deg
        if tilt > most:
            self._lost = True
            raise PalpateError(
                f"The sensor is tilted by {tilt:.1f}° from its start, over twice the maximum tilt ({most:g}°).",
                "Move it back to its start by the robot's own control, and start the same command again.",
                code="robot-far",
            )
        if pose[2] > -0.5 * self._spec.clear:
            clear = np.append(pose[:2], -self._spec.clear)
            self._move(clear, here.moved(-(pose[2] + self._spec.clear) * here.rotation[:, 2]))
            return clear
        return pose

    def _move(self, pose: FloatArray, flange: Placement | None = None) -> None:
        """Move to a pose (3,), by default over the start, or to a `flange` pose of that tilt and depth."""
        where = f"depth {pose[2]:.3f} mm" if pose[2] > 0 else f"the wall {-pose[2]:g} mm clear of the skin"
        tilt, azimuth = np.hypot(*pose[:2]), np.degrees(np.arctan2(pose[1], pose[0]))
        tilted = f"rx {pose[0]:.3f}°, ry {pose[1]:.3f}° (tilt {tilt:.3f}° about the axis at {azimuth:.1f}°)"
        self._robot.announce(f"{tilted}, {where}")
        self._lost = True
        self._robot.move(self._frame.flange_at(pose) if flange is None else flange)
        self._lost = False
