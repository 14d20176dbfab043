"""Twin: the forward model of a built unit, from the pose of what presses it to the pixels of its markers."""

from palpate.twin.field import MarkerField, build_field
from palpate.twin.jacobian import image_jacobian
from palpate.twin.tilt_runs import TiltRuns, cut_into_runs, label_presses, match_depths, shared_depths

__all__ = [
    "MarkerField",
    "TiltRuns",
    "build_field",
    "cut_into_runs",
    "image_jacobian",
    "label_presses",
    "match_depths",
    "shared_depths",
]
