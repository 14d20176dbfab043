"""Twin: where every marker goes and what the wall bears, interpolated from presses for any pose and friction."""

from palpate.twin.batch_twin import BatchTwin
from palpate.twin.build_field import build_field
from palpate.twin.build_twin import build_twin, twin_derivatives
from palpate.twin.jacobian import image_jacobian
from palpate.twin.measure_off import measure_interpolation_error
from palpate.twin.press_field import PressField, Series, surface_displacement
from palpate.twin.tilt_runs import interpolate_depths
from palpate.twin.twin import LATERAL, TWIN_DERIVATIVES, TWIN_STATE, MarkerState, MarkerTwin, Twin
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
    "LATERAL",
    "TWIN_DERIVATIVES",
    "TWIN_STATE",
    "TWIN_VERSION",
    "BatchTwin",
    "MarkerState",
    "MarkerTwin",
    "PressField",
    "Series",
    "Twin",
    "build_field",
    "build_twin",
    "find_twin",
    "image_jacobian",
    "interpolate_depths",
    "measure_interpolation_error",
    "read_twin",
    "surface_displacement",
    "twin_derivatives",
    "twin_path",
    "twin_relaxation",
    "twin_version",
    "write_twin",
]
