"""Pose estimate: the one type of a pose with its uncertainty."""

from __future__ import annotations

from dataclasses import dataclass, field

from palpate.core import FloatArray
from palpate.design.pose_space import TILT_SPACE, PoseSpace


@dataclass(frozen=True, eq=False)
class PoseEstimate:
    """Estimated pose of the obstacle in one image or in n images.

    Attributes
    ----------
    pose
        (k,) of one image or (n, k), by the names and units of `space`; NaN without an estimate.
    half_width
        Half-widths of the intervals, in the shape and units of `pose`; infinite if unknown.
    space
        Components of the pose.
    """

    pose: FloatArray
    half_width: FloatArray
    space: PoseSpace = field(default=TILT_SPACE, kw_only=True)
