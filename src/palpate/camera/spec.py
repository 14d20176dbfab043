"""What a person may choose about the camera; the defaults are the DAVIS 346 of the paper."""

from __future__ import annotations

from typing import Any, Self

from pydantic import SerializerFunctionWrapHandler, model_serializer, model_validator
from pydantic_core import PydanticCustomError

from palpate.camera.lens import LENSES, make_lens
from palpate.camera.window import WindowSpec
from palpate.core import PAPER, Spec, parameter

CALIBRATION = f"calibration published with {PAPER}"
BROWN = "brown"


class CameraSpec(Spec):
    """A camera below the dome's base, looking up the axis.

    The pose is nominal (on the axis, image axes along the dome's x and y) unless moved or turned.
    """

    width_px: int = parameter(346, unit="px", meaning="width of the image", source="DAVIS 346", ge=8, le=16384)
    height_px: int = parameter(260, unit="px", meaning="height of the image", source="DAVIS 346", ge=8, le=16384)
    fx_px: float = parameter(297.38, unit="px", meaning="focal length across", source=CALIBRATION, gt=0)
    fy_px: float = parameter(297.60, unit="px", meaning="focal length down", source=CALIBRATION, gt=0)
    cx_px: float = parameter(174.91, unit="px", meaning="principal point, column", source=CALIBRATION)
    cy_px: float = parameter(128.22, unit="px", meaning="principal point, row", source=CALIBRATION)
    lens: str = parameter(BROWN, unit="", meaning="brown, kannala-brandt (fisheye), or a lens of another package")
    distortion: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0, 0.0, 0.0),
        unit="1",
        meaning="coefficients of the lens as in OpenCV: k1, k2, p1, p2, k3, or k1 to k4 of a fisheye",
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
    window: WindowSpec | None = parameter(
        None,
        unit="",
        meaning="flat window in the base plane, and the gel behind it; empty: air all the way to the markers",
    )

    @model_validator(mode="before")
    @classmethod
    def _ideal_lens(cls, given: Any) -> Any:
        """A lens without coefficients has them all zero, as many as it takes."""
        if isinstance(given, dict) and "lens" in given and "distortion" not in given:
            return {**given, "distortion": (0.0,) * len(LENSES.get(str(given["lens"])).parameters())}
        return given

    @model_validator(mode="after")
    def _known_lens(self) -> Self:
        make_lens(self.lens, self.distortion)
        return self

    @model_validator(mode="after")
    def _window_before_the_pinhole(self) -> Self:
        if self.window is not None and self.window.thickness >= self.distance:
            raise PydanticCustomError(
                "window-beyond-camera",
                "a window of {thickness} mm ends behind the camera, {distance} mm below the base; move the camera "
                "away or take a thinner window",
                {"thickness": f"{self.window.thickness:g}", "distance": f"{self.distance:g}"},
            )
        return self

    @model_serializer(mode="wrap")
    def _leave_out_brown(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Brown's lens in air is written as before there was another, so that old artefacts keep their keys."""
        content: dict[str, Any] = dump(self)
        if self.lens == BROWN:
            content.pop("lens", None)
        if self.window is None:
            content.pop("window", None)
        return content
