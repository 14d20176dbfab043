"""Configuration of an alignment of a tool, and of the simulated robot."""

from __future__ import annotations

from palpate.core import Spec, parameter


class AlignSpec(Spec):
    """Presses of an alignment, its tolerance, and the uncertainty of the robot."""

    tolerance_deg: float = parameter(
        0.3,
        unit="deg",
        meaning="upper limit of the interval of the angle between tool and wall normal",
        gt=0,
        le=10,
    )
    level: float = parameter(0.9, unit="1", meaning="coverage of the interval of the angle", gt=0, lt=1)
    max_touches: int = parameter(6, unit="1", meaning="maximum number of presses per wall", ge=1, le=100)
    depth: float = parameter(5.0, unit="mm", meaning="depth of a press, if the force limit allows it", gt=0, le=60)
    min_depth: float = parameter(2.0, unit="mm", meaning="minimum depth of an evaluated angle", gt=0, le=60)
    force_n: float = parameter(0.5, unit="N", meaning="maximum normal force", gt=0, le=1000)
    step: float = parameter(0.5, unit="mm", meaning="travel between two images before first contact", gt=0, le=5)
    search: float = parameter(12.0, unit="mm", meaning="maximum travel of the search for the wall", gt=0, le=1000)
    clear: float = parameter(3.0, unit="mm", meaning="distance from the wall at which the flange is rotated", gt=0)
    near_deg: float = parameter(
        2.0, unit="deg", meaning="maximum tilt of the final reading", source="gains err by a share", gt=0
    )
    max_image_retries: int = parameter(
        5, unit="1", meaning="maximum number of images at one pose before it counts as unreadable", ge=1, le=100
    )
    robot_deg: float = parameter(
        0.05, unit="deg", meaning="standard deviation of the robot's rotation, about each axis", ge=0, le=5
    )
    robot_mm: float = parameter(
        0.1, unit="mm", meaning="standard deviation of the robot's position, along each axis", ge=0, le=5
    )
