"""Surrogate: the twin: markers and force for any pose and friction, interpolated from presses."""

from palpate.surrogate.batch_twin import BatchTwin
from palpate.surrogate.build_field import build_field
from palpate.surrogate.build_twin import build_twin, twin_derivatives
from palpate.surrogate.interpolation_error import measure_interpolation_error
from palpate.surrogate.jacobian import image_jacobian
from palpate.surrogate.press_field import PressField, Series, surface_displacement
from palpate.surrogate.tilt_runs import interpolate_depths
from palpate.surrogate.twin import LATERAL, TWIN_DERIVATIVES, TWIN_STATE, MarkerState, MarkerTwin, Twin
from palpate.surrogate.twin_file import (
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
