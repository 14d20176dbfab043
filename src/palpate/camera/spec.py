"""What a person may choose about the camera; the defaults are the DAVIS 346 of the paper."""

from __future__ import annotations

from palpate.core import Spec, parameter

CALIBRATION = "calibration published with Zaid et al. 2024, doi 10.1016/j.sna.2024.115469"


class CameraSpec(Spec):
    """A pinhole camera with lens distortion below the dome's base, looking up the axis.

    The pose is nominal (on the axis, image axes along the dome's x and y) unless moved or turned.
    """

    width_px: int = parameter(346, unit="px", meaning="width of the image", source="DAVIS 346", ge=8, le=16384)
    height_px: int = parameter(260, unit="px", meaning="height of the image", source="DAVIS 346", ge=8, le=16384)
    fx_px: float = parameter(297.38, unit="px", meaning="focal length across", source=CALIBRATION, gt=0)
    fy_px: float = parameter(297.60, unit="px", meaning="focal length down", source=CALIBRATION, gt=0)
    cx_px: float = parameter(174.91, unit="px", meaning="principal point, column", source=CALIBRATION)
    cy_px: float = parameter(128.22, unit="px", meaning="principal point, row", source=CALIBRATION)
    distortion: tuple[float, float, float, float, float] = parameter(
        (0.0, 0.0, 0.0, 0.0, 0.0),
        unit="1",
        meaning="lens distortion k1, k2, p1, p2, k3 as in OpenCV",
        source="none published for the paper's lens",
    )
    distance: float = parameter(
        48.0,
        unit="mm",
        meaning="distance below the base plane",
        source=CALIBRATION,
        flag="camera-distance",
        gt=0,
        le=1000,
    )
    offset_x: float = parameter(0.0, unit="mm", meaning="offset from the dome's axis along x", ge=-50, le=50)
    offset_y: float = parameter(0.0, unit="mm", meaning="offset from the dome's axis along y", ge=-50, le=50)
    tilt_x_deg: float = parameter(0.0, unit="deg", meaning="turn of the camera about the dome's x", ge=-45, le=45)
    tilt_y_deg: float = parameter(0.0, unit="deg", meaning="turn of the camera about the dome's y", ge=-45, le=45)
    roll_deg: float = parameter(0.0, unit="deg", meaning="turn of the camera about its optical axis", ge=-180, le=180)
