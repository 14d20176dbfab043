"""Choice of the next press of a recording in progress by the unit identified from the presses so far."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from palpate.calibration import AccuracySpec, RobotUncertainty, calibration_pose, rank_next_presses
from palpate.camera import read_image
from palpate.rig.take_spec import PlannedPress, TakeSpec
from palpate.sensor import SensorSpec, Unit, identify_unit, open_sensor, read_ground_truth
from palpate.surrogate import Twin


def choose_next_press(
    before: Sequence[PlannedPress],
    table: Path,
    unit: Unit,
    twin: Twin,
    spec: TakeSpec,
    robot: RobotUncertainty | None = None,
) -> PlannedPress:
    """Return the press that reduces the predicted error of a unit most, at a pose without a press so far.

    Parameters
    ----------
    before
        Presses so far; the first press is that of `palpate.calibration.calibration_pose`.
    table
        Poses of the recording so far, in the folder of its images.
    unit, twin
        The unit, and the twin of its design.
    spec
        Working range of the recording.
    robot
        Uncertainty of the robot's poses.

    Raises
    ------
    PalpateError
        If the presses so far do not fit a unit of this design.
    """
    most, robot = min(spec.max_tilt_deg, float(twin.tilts_deg[-1])), robot or RobotUncertainty()
    if not before:
        return calibration_pose(0, most)
    known = read_ground_truth(table).locate(table.parent)
    sensor = open_sensor([read_image(Path(name)) for name in known.rest], unit, twin, SensorSpec())
    found = identify_unit(sensor, known.presses(), robot)
    fitter = sensor.estimator.twin_fit
    assert fitter is not None, "it reads by a twin"
    accuracy = AccuracySpec(
        noise_px=fitter.noise_px, robot=robot, max_tilt_deg=most, min_depth=float(spec.depths_mm[0])
    )
    friction = float(np.median(found.inverse_frictions))
    ranked = rank_next_presses(fitter.model, found.mounting, friction, accuracy)[1]
    places = [(press.tilt_deg, press.azimuth_deg) for press in ranked]
    return next((place for place in places if place not in before), places[0])
