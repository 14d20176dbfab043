"""Acquisition of a recording: rest images, and presses of one wall by a robot.

Each press starts clear of the wall and goes deeper along the sensor's axis; it waits, checks and writes an image at
every depth. After an interruption the acquisition resumes at the first image that has no row. After an error of the
camera the sensor is retracted; after an error of the robot, the robot is left as it is.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, PalpateError
from palpate.core.run import Progress
from palpate.design import Skin, rotation_vector
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
        If the robot does not answer.
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
        self._moving = False
        if "start" not in folder.plan:
            here = robot.flange_pose()
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
            if not self._moving:
                with suppress(PalpateError):
                    self._retract()
            raise

    def _press(self, number: int, tilt: float, azimuth: float) -> None:
        """Take the missing images of one press; the flange starts and ends clear of the wall."""
        label = f"press {number + 1}, {tilt:.2f}° towards {azimuth:.1f}°"
        self._progress.begin(label)
        todo = [
            (name, depth)
            for image, depth in enumerate(self._spec.depths_mm)
            if (name := f"press_{number:03d}_{image:02d}.png") not in self._folder
        ]
        if todo:
            self._retract()
            tilted = np.append(rotation_vector(tilt, np.radians(azimuth)), -self._spec.clear)
            self._move(tilted)
            for name, depth in todo:
                self._move(np.append(tilted[:2], depth))
                time.sleep(self._spec.dwell_s)
                self._before = take_image(self._next_image, self._before, self._spec)
                pose = self._frame.pose_at(self._robot.flange_pose())
                self._folder.add(name, self._before, str(number + 1), pose)
            self._retract()
        self._progress.finish(label)

    def _retract(self) -> None:
        """Move back along the sensor's axis until the skin is clear of the wall; no move if it is."""
        pose = self._frame.pose_at(self._robot.flange_pose())
        if pose[2] > -0.5 * self._spec.clear:
            self._move(np.append(pose[:2], -self._spec.clear))

    def _move(self, pose: FloatArray) -> None:
        where = f"depth {pose[2]:.3f} mm" if pose[2] > 0 else f"the wall {-pose[2]:g} mm clear of the skin"
        tilt, azimuth = np.hypot(*pose[:2]), np.degrees(np.arctan2(pose[1], pose[0]))
        tilted = f"rx {pose[0]:.3f}°, ry {pose[1]:.3f}° (tilt {tilt:.3f}° towards {azimuth:.1f}°)"
        self._robot.announce(f"{tilted}, {where}")
        self._moving = True
        self._robot.move(self._frame.flange_at(pose))
        self._moving = False
