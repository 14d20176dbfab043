"""Identify the unit of an open sensor by presses whose poses the robot says."""

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
    StiffnessScale,
    identify,
    prior_stiffness_scale,
    update_stiffness_scale,
)
from palpate.core import FloatArray, PalpateError
from palpate.sensor.pose_estimator import TwinEstimator
from palpate.sensor.reading import Flag
from palpate.sensor.sensor import Sensor

KnownImages = tuple[FloatArray, Iterable[NDArray[Any]], FloatArray]
"""Poses (n, 3) rx, ry (degrees) and depth (mm) that the robot says of one press, its images, and a load cell's
readings (n,) N along the wall's normal; NaN where there is none."""


class _Seen(NamedTuple):
    """Dots of the images of a press that touch, and the load cell's readings (n,) N."""

    press: CalibrationPress
    forces: FloatArray


def identify_unit(
    sensor: Sensor, presses: Iterable[KnownImages], robot: RobotUncertainty | None = None, *, on_robot: bool = True
) -> IdentificationResult:
    """Learn the sensor's unit, mounting and stiffness from known presses; it reads by them from then on.

    Images with few dots or no touch are left out, and so are those that no press of the unit looks like.

    Parameters
    ----------
    sensor
        Opened with the design's twin.
    presses
        Poses and images of each press, and the load cell's readings of those that have any.
    robot
        How well it knows its poses and forces.
    on_robot
        Whether poses are on the robot's scale from then on; otherwise they stay in the dome's frame, as for a unit
        that is taken off it.

    Raises
    ------
    PalpateError
        If the sensor reads by a network, an image has no pose, or where `palpate.calibration.identify` fails.
    """
    reader, noise, robot = sensor.estimator, sensor.spec.noise_px, robot or RobotUncertainty()
    if not isinstance(reader, TwinEstimator):
        raise PalpateError(
            "A network cannot learn its unit.", "Open the sensor with the design's twin.", code="network-no-unit"
        )
    model = reader.fitter.model
    seen = [_see(sensor, press) for press in presses]
    found = identify(model, [each.press for each in seen], noise, robot)
    known = model.with_posterior(found.posterior)
    scale = _weigh(PoseFitter(known, noise, found.mounting, StiffnessScale(1.0, 0.0)), seen, robot.force)
    sensor.fit_by(PoseFitter(known, noise, found.mounting if on_robot else None, scale))
    return replace(found, scale=scale)


def _weigh(fitter: PoseFitter, seen: list[_Seen], cell_sd: float) -> StiffnessScale:
    """The unit's stiffness over the design's, from the images that have a load cell's reading."""
    expected, measured = [], []
    for press, forces in seen:
        for pixels, force in zip(press.pixels, forces, strict=True):
            if np.isfinite(force):
                expected.append(fitter.fit(pixels).force.normal_force)
                measured.append(float(force))
    return update_stiffness_scale(prior_stiffness_scale(fitter.model.tolerance), expected, measured, cell_sd)


def _see(sensor: Sensor, known: KnownImages) -> _Seen:
    """The dots of a press."""
    poses, images, forces = known
    readings = [sensor.read(image) for image in images]
    if len(readings) != len(poses):
        raise PalpateError(
            f"{len(readings)} images have {len(poses)} poses.", "Give each image its pose.", code="pose-count-differs"
        )
    kept = [
        (pose, seen.sighting, force)
        for pose, seen, force in zip(poses, readings, forces, strict=True)
        if seen.sighting is not None and seen.touching and Flag.MISFIT not in seen.flags
    ]
    if not kept:
        raise PalpateError(
            "No image of a known press shows a touch that this unit could show.",
            "Press deeper, check the light, and that design and recording belong together.",
            code="calibration-press-no-touch",
        )
    pixels = [np.where(seen.found[:, None], seen.positions_px, np.nan) for _, seen, _ in kept]
    press = CalibrationPress(np.array([pose for pose, _, _ in kept]), np.array(pixels))
    return _Seen(press, np.array([force for *_, force in kept]))
