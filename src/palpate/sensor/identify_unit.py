"""Identification of the unit of an open sensor by calibration presses."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from palpate.calibration import (
    CalibrationPress,
    IdentificationResult,
    PoseFitter,
    RobotUncertainty,
    ScalarEstimate,
    identify,
    prior_stiffness_scale,
    update_stiffness_scale,
)
from palpate.core import FloatArray, PalpateError
from palpate.sensor.pose_estimator import TwinEstimator
from palpate.sensor.reading import Flag
from palpate.sensor.sensor import Sensor

KnownImages = tuple[FloatArray, Iterable[NDArray[Any]], FloatArray]
"""Calibration press: robot poses, images, and load cell readings.

Poses are (n, 3) rx, ry (degrees) and depth (mm); readings are (n,) N along the wall normal, NaN without one.
"""


class _Seen(NamedTuple):
    """Marker positions of the images in contact, and readings (n,) N of the load cell."""

    press: CalibrationPress
    forces: FloatArray


def identify_unit(
    sensor: Sensor, presses: Iterable[KnownImages], robot: RobotUncertainty | None = None, *, on_robot: bool = True
) -> IdentificationResult:
    """Identify unit, mounting and stiffness by calibration presses, and use them in later readings.

    Images without contact, with few markers or with a misfit are left out.

    Parameters
    ----------
    sensor
        Opened with the design's twin.
    presses
        Poses and images of each press, and its load cell readings if it has any.
    robot
        Uncertainty of poses and forces.
    on_robot
        Whether later poses are on the robot's scale; otherwise they are in the skin's frame, as for a unit that is
        removed from the robot.

    Raises
    ------
    PalpateError
        If the sensor reads by a network, an image has no pose, or `palpate.calibration.identify` fails.
    """
    reader, noise, robot = sensor.estimator, sensor.spec.noise_px, robot or RobotUncertainty()
    if not isinstance(reader, TwinEstimator):
        raise PalpateError(
            "A network cannot identify its unit.", "Open the sensor with the design's twin.", code="network-no-unit"
        )
    model = reader.fitter.model
    seen = [_see(sensor, press) for press in presses]
    found = identify(model, [each.press for each in seen], noise, robot)
    known = model.with_posterior(found.posterior)
    scale = _weigh(PoseFitter(known, noise, found.mounting, ScalarEstimate(1.0, 0.0)), seen, robot.force)
    sensor.fit_by(PoseFitter(known, noise, found.mounting if on_robot else None, scale))
    return replace(found, scale=scale)


def _weigh(fitter: PoseFitter, seen: list[_Seen], cell_sd: float) -> ScalarEstimate:
    """Estimate the unit's relative stiffness from the images with a load cell reading."""
    expected, measured = [], []
    for press, forces in seen:
        for pixels, force in zip(press.pixels, forces, strict=True):
            if np.isfinite(force):
                expected.append(fitter.fit(pixels).force.normal_force)
                measured.append(float(force))
    return update_stiffness_scale(prior_stiffness_scale(fitter.model.tolerance), expected, measured, cell_sd)


def _see(sensor: Sensor, known: KnownImages) -> _Seen:
    """Read the markers of a press."""
    poses, images, forces = known
    readings = [sensor.read(image) for image in images]
    if len(readings) != len(poses):
        raise PalpateError(
            f"{len(readings)} images have {len(poses)} poses.",
            "Give each image its pose.",
            code="pose-count-differs",
        )
    kept = [
        (pose, seen.sighting, force)
        for pose, seen, force in zip(poses, readings, forces, strict=True)
        if seen.sighting is not None and seen.touching and Flag.MISFIT not in seen.flags
    ]
    if not kept:
        raise PalpateError(
            "No image of the calibration press shows a contact that the twin can explain.",
            "Press deeper, and check the light and that design and recording belong together.",
            code="calibration-press-no-touch",
        )
    pixels = [np.where(seen.found[:, None], seen.positions_px, np.nan) for _, seen, _ in kept]
    press = CalibrationPress(np.array([pose for pose, _, _ in kept]), np.array(pixels))
    return _Seen(press, np.array([force for *_, force in kept]))
