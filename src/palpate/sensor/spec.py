"""Configuration of the readings, the acceptance test and the inspection of a sensor."""

from __future__ import annotations

from palpate.calibration import NOISE_PX
from palpate.core import PAPER, Spec, parameter
from palpate.design import PRINT_TOLERANCE

TABLE_3 = f"{PAPER}, Table 3"


class SensorSpec(Spec):
    """Thresholds of contact, flags and drift tracking, and settings of the rest image."""

    touch_px: float = parameter(
        0.25, unit="px", meaning="RMS displacement of the markers above which the skin is in contact", gt=0, le=20
    )
    min_found: float = parameter(0.6, unit="1", meaning="minimum share of markers found for a pose", gt=0, le=1)
    rest_images: int = parameter(1, unit="1", meaning="number of averaged rest images", ge=1, le=1000)
    refine_lens: bool = parameter(
        False, unit="", meaning="whether focal length and centre of the lens are fitted to the rest image"
    )
    noise_px: float = parameter(
        NOISE_PX, unit="px", meaning="standard deviation of a marker coordinate in one image", gt=0, le=5
    )
    misfit: float = parameter(
        4.0,
        unit="1",
        meaning="mean square residual of a fit over its expected value, above which a reading is flagged",
        gt=1,
    )
    follow_px: float = parameter(
        2.0,
        unit="px",
        meaning="maximum RMS drift of the unloaded markers that is tracked; 0: drift is not tracked",
        ge=0,
        le=20,
    )
    drift_px: float = parameter(
        0.5,
        unit="px",
        meaning="median shift of the markers in the rest image above which an identified unit is rejected",
        gt=0,
        le=50,
    )


class AcceptanceSpec(Spec):
    """Tolerances of the acceptance test, and settings of its evaluation."""

    rmse_deg: float = parameter(
        0.58, unit="deg", meaning="maximum RMSE of roll, pitch and total angle", source=TABLE_3, gt=0
    )
    max_deg: float = parameter(
        1.64,
        unit="deg",
        meaning="maximum error of roll, pitch and total angle",
        source=TABLE_3,
        flag="max-error",
        gt=0,
    )
    depth_rmse: float = parameter(0.2, unit="mm", meaning="maximum RMSE of the depth", gt=0)
    min_depth: float = parameter(2.4, unit="mm", meaning="minimum depth of the evaluated images", ge=0)
    without_pose: float = parameter(0.0, unit="1", meaning="maximum share of images without a pose", ge=0, le=1)
    zero: bool = parameter(True, unit="", meaning="whether the zero of the depth is determined from the first press")
    guard: bool = parameter(
        True,
        unit="",
        meaning="whether the expanded uncertainty U of a figure is a guard band; otherwise simple acceptance",
        source="ISO 14253-1: conformity is proven if figure + U ≤ tolerance",
    )
    seed: int = parameter(0, unit="1", meaning="seed of the bootstrap", ge=0)


class InspectionSpec(Spec):
    """Tolerance of the print of a unit."""

    tolerance: float = parameter(PRINT_TOLERANCE, unit="mm", meaning="maximum print error of a marker", gt=0, le=5)
