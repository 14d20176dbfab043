"""Configuration of the camera; the defaults are the DAVIS 346 of the paper."""

from __future__ import annotations

from typing import Any, Self

from pydantic import SerializerFunctionWrapHandler, model_serializer, model_validator
from pydantic_core import PydanticCustomError

from palpate.camera.lens import LENSES, make_lens
from palpate.camera.window import WindowSpec
from palpate.core import PAPER, PalpateError, Spec, parameter

CALIBRATION = f"calibration published with {PAPER}"
BROWN = "brown"


class CameraSpec(Spec):
    """Camera below the base of the skin, looking up along its axis.

    The nominal pose is on the axis, with image axes along the skin's x and y; offsets and rotations change it.
    """

    width_px: int = parameter(346, unit="px", meaning="width of the image", source="DAVIS 346", ge=8, le=16384)
    height_px: int = parameter(260, unit="px", meaning="height of the image", source="DAVIS 346", ge=8, le=16384)
    fx_px: float = parameter(297.38, unit="px", meaning="focal length, horizontal", source=CALIBRATION, gt=0)
    fy_px: float = parameter(297.60, unit="px", meaning="focal length, vertical", source=CALIBRATION, gt=0)
    cx_px: float = parameter(174.91, unit="px", meaning="principal point, column", source=CALIBRATION)
    cy_px: float = parameter(128.22, unit="px", meaning="principal point, row", source=CALIBRATION)
    lens: str = parameter(
        BROWN,
        unit="",
        meaning="lens model: brown, kannala-brandt (fisheye), rational, or one of an installed package",
    )
    distortion: tuple[float, ...] = parameter(
        (0.0, 0.0, 0.0, 0.0, 0.0),
        unit="1",
        meaning="distortion coefficients as in OpenCV: k1, k2, p1, p2, k3, or k1 to k4 of a fisheye lens",
        source="none published for the paper's lens",
    )
    distance: float = parameter(
        48.0,
        unit="mm",
        meaning="distance of the camera below the base plane",
        source=CALIBRATION,
        flag="camera-distance",
        gt=0,
        le=1000,
    )
    offset_x: float = parameter(0.0, unit="mm", meaning="offset from the skin's axis along x", ge=-50, le=50)
    offset_y: float = parameter(0.0, unit="mm", meaning="offset from the skin's axis along y", ge=-50, le=50)
    tilt_x_deg: float = parameter(0.0, unit="deg", meaning="rotation of the camera about the skin's x", ge=-45, le=45)
    tilt_y_deg: float = parameter(0.0, unit="deg", meaning="rotation of the camera about the skin's y", ge=-45, le=45)
    roll_deg: float = parameter(0.0, unit="deg", meaning="rotation about the optical axis", ge=-180, le=180)
    window: WindowSpec | None = parameter(
        None,
        unit="",
        meaning="flat window in the base plane, and the gel behind it; empty: air up to the markers",
    )

    @model_validator(mode="before")
    @classmethod
    def _ideal_lens(cls, given: Any) -> Any:
        """Set all coefficients of a lens to zero if they are not given."""
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
                "the window is {thickness} mm thick, and the camera is {distance} mm below the base; increase the "
                "distance or choose a thinner window",
                {"thickness": f"{self.window.thickness:g}", "distance": f"{self.distance:g}"},
            )
        return self

    def scaled_to(self, width_px: int, height_px: int) -> Self:
        """Return the camera of an image of another size, binned or enlarged by an exact ratio.

        Raises
        ------
        PalpateError
            If width and height have different ratios: the image was cropped, or is of another camera.
        """
        if (width_px, height_px) == (self.width_px, self.height_px):
            return self
        if width_px * self.height_px != height_px * self.width_px:
            raise PalpateError(
                f"The lens is of {self.width_px} × {self.height_px} px, the image has {width_px} × {height_px} px, "
                "and no single ratio connects them.",
                "Give the lens of images of this size: `palpate calibration camera`, then --lens.",
                code="lens-image-size",
            )
        ratio = width_px / self.width_px
        middle = {name: (getattr(self, name) + 0.5) * ratio - 0.5 for name in ("cx_px", "cy_px")}
        focal = {name: getattr(self, name) * ratio for name in ("fx_px", "fy_px")}
        return self.model_copy(update={"width_px": width_px, "height_px": height_px} | middle | focal)

    @model_serializer(mode="wrap")
    def _leave_out_brown(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Leave out the default lens and window, so that older artefacts keep their keys."""
        content: dict[str, Any] = dump(self)
        if self.lens == BROWN:
            content.pop("lens", None)
        if self.window is None:
            content.pop("window", None)
        return content
