"""Identify the unit of an open sensor by presses whose poses the robot says."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.built import Identified, PoseFitter, RobotPress, RobotSpec, identify
from palpate.core import FloatArray, PalpateError
from palpate.sensor.reader import TwinReader
from palpate.sensor.reading import Flag
from palpate.sensor.sensor import Sensor

KnownImages = tuple[FloatArray, Iterable[NDArray[Any]]]
"""Poses (n, 3) rx, ry (degrees) and depth (mm) that the robot says of one press, and its images."""


def identify_unit(sensor: Sensor, presses: Iterable[KnownImages], robot: RobotSpec | None = None) -> Identified:
    """Learn the sensor's unit and mounting from known presses; the sensor reads on the robot's scale from then on.

    Images with few dots or no touch are left out, and so are those that no press of the unit looks like.

    Parameters
    ----------
    sensor
        Opened with the design's twin.
    presses
        Poses and images of each press.
    robot
        How well it knows its poses.

    Raises
    ------
    PalpateError
        If the sensor reads by a network, an image has no pose, or where `palpate.built.identify` fails.
    """
    reader, noise = sensor.reader, sensor.spec.noise_px
    if not isinstance(reader, TwinReader):
        raise PalpateError("A network cannot learn its unit.", "Open the sensor with the design's twin.")
    model = reader.fitter.model
    found = identify(model, [_see(sensor, *press) for press in presses], noise, robot)
    reader.fitter = PoseFitter(model.believing(found.belief), noise, found.mounting)
    return found


def _see(sensor: Sensor, poses: FloatArray, images: Iterable[NDArray[Any]]) -> RobotPress:
    """The dots of a press."""
    readings = [sensor.read(image) for image in images]
    if len(readings) != len(poses):
        raise PalpateError(f"{len(readings)} images have {len(poses)} poses.", "Give each image its pose.")
    kept = [
        (pose, seen.sighting)
        for pose, seen in zip(poses, readings, strict=True)
        if seen.sighting is not None and seen.touching and Flag.MISFIT not in seen.flags
    ]
    if not kept:
        raise PalpateError(
            "No image of a known press shows a touch that this unit could show.",
            "Press deeper, check the light, and that design and recording belong together.",
        )
    pixels = [np.where(seen.found[:, None], seen.positions_px, np.nan) for _, seen in kept]
    return RobotPress(np.array([pose for pose, _ in kept]), np.array(pixels))
