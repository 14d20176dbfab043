"""What a person may choose about squaring a tool, and about the simulated robot."""

from __future__ import annotations

from palpate.core import Spec, parameter


class AlignSpec(Spec):
    """How a wall is touched, and when the tool is square enough."""

    tolerance_deg: float = parameter(
        0.3,
        unit="deg",
        meaning="angle between drill and wall's normal that its interval must stay below",
        gt=0,
        le=10,
    )
    level: float = parameter(0.9, unit="1", meaning="what the interval of the angle covers", gt=0, lt=1)
    max_touches: int = parameter(6, unit="1", meaning="touches after which it gives up", ge=1, le=100)
    depth: float = parameter(5.0, unit="mm", meaning="depth of a touch, where the force allows it", gt=0, le=60)
    min_depth: float = parameter(2.0, unit="mm", meaning="least depth at which an angle counts", gt=0, le=60)
    force_n: float = parameter(0.5, unit="N", meaning="force along the normal that is never passed", gt=0, le=1000)
    step: float = parameter(0.5, unit="mm", meaning="travel between two images before the first touch", gt=0, le=5)
    search: float = parameter(12.0, unit="mm", meaning="travel after which there is no wall", gt=0, le=1000)
    clear: float = parameter(3.0, unit="mm", meaning="distance from the wall at which the flange is turned", gt=0)
    near_deg: float = parameter(
        2.0, unit="deg", meaning="tilt below which a reading may be the last", source="gains err by a share", gt=0
    )
    max_image_retries: int = parameter(
        5, unit="1", meaning="images of one place before it counts as unreadable", ge=1, le=100
    )
    robot_deg: float = parameter(
        0.05, unit="deg", meaning="standard deviation of the robot's turns, about each axis", ge=0, le=5
    )
    robot_mm: float = parameter(
        0.1, unit="mm", meaning="standard deviation of the robot's places, along each axis", ge=0, le=5
    )
