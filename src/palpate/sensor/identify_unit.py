"""Identify the unit of an open sensor by presses whose poses the robot says."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray, PalpateError
from palpate.learn import PoseFitter
from palpate.sensor.reader import TwinReader
from palpate.sensor.sensor import Sensor
from palpate.twin import Identified, RobotPress, RobotSpec, identify, model_unit


def see_press(sensor: Sensor, poses: FloatArray, images: Iterable[NDArray[Any]]) -> RobotPress:
    """Read the dots of a press whose poses (n, 3) the robot says; images with few dots or no touch are left out.

    Raises
    ------
    PalpateError
        If there are not as many images as poses, or none can be read.
    """
    readings = [sensor.read(image) for image in images]
    if len(readings) != len(poses):
        raise PalpateError(f"{len(readings)} images have {len(poses)} poses.", "Give each image its pose.")
    kept = [
        (pose, seen.sighting)
        for pose, seen in zip(poses, readings, strict=True)
        if seen.sighting is not None and seen.touching
    ]
    if not kept:
        raise PalpateError(
            "No image of a known press shows a touch that can be read.", "Press deeper, and check light and focus."
        )
    pixels = [np.where(seen.found[:, None], seen.positions_px, np.nan) for _, seen in kept]
    return RobotPress(np.array([pose for pose, _ in kept]), np.array(pixels))


def identify_unit(sensor: Sensor, presses: Iterable[RobotPress], robot: RobotSpec | None = None) -> Identified:
    """Learn the sensor's unit and mounting from known presses; the sensor reads on the robot's scale from then on.

    Raises
    ------
    PalpateError
        If the sensor reads by a network, or where `palpate.twin.identify` fails.
    """
    reader, unit, noise = sensor.reader, sensor.unit, sensor.spec.noise_px
    if not isinstance(reader, TwinReader):
        raise PalpateError("A network cannot learn its unit.", "Open the sensor with the design's twin.")
    model = reader.fitter.model
    found = identify(model.dots.twin, unit.layout, model.belief, tuple(presses), unit.tolerance, noise, robot)
    learnt = model_unit(model.dots.twin, unit.layout, found.belief, unit.tolerance)
    reader.fitter = PoseFitter(learnt, noise, found.mounting)
    return found
