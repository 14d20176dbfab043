"""Twin: where every marker goes and what the wall bears, interpolated from presses for any pose and friction."""

from palpate.twin.batch_twin import BatchTwin
from palpate.twin.build_field import build_field
from palpate.twin.build_twin import TWIN_DERIVATIVES, build_twin
from palpate.twin.force_field import ForceField, build_force_field
from palpate.twin.jacobian import image_jacobian
from palpate.twin.marker_field import MarkerField
from palpate.twin.measure_off import measure_interpolation_error
from palpate.twin.tilt_runs import TiltRuns, cut_into_runs, label_presses, match_depths, shared_depths
from palpate.twin.turned_presses import MIRRORS
from palpate.twin.turned_series import TwoMirrorSeries, TwoMirrorTable
from palpate.twin.twin import MarkerState, MarkerTwin, Twin
from palpate.twin.twin_file import (
    TWIN_VERSION,
    find_twin,
    read_twin,
    twin_path,
    twin_relaxation,
    twin_version,
    write_twin,
)

__all__ = [
    "MIRRORS",
    "TWIN_DERIVATIVES",
    "TWIN_VERSION",
    "BatchTwin",
    "ForceField",
    "MarkerField",
    "MarkerState",
    "MarkerTwin",
    "TiltRuns",
    "Twin",
    "TwoMirrorSeries",
    "TwoMirrorTable",
    "build_field",
    "build_force_field",
    "build_twin",
    "cut_into_runs",
    "find_twin",
    "image_jacobian",
    "label_presses",
    "match_depths",
    "measure_interpolation_error",
    "read_twin",
    "shared_depths",
    "twin_path",
    "twin_relaxation",
    "twin_version",
    "write_twin",
]
