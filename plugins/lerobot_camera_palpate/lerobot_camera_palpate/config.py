"""Settings of the camera."""

from __future__ import annotations

from dataclasses import dataclass

from lerobot.cameras.configs import CameraConfig, ColorMode


@CameraConfig.register_subclass("palpate")
@dataclass(kw_only=True)
class PalpateCameraConfig(CameraConfig):
    """Camera of a tactile sensor.

    Attributes
    ----------
    source
        Number of a camera, a video, or a folder of images, as palpate opens them.
    twin
        File of the design's twin; with it, `PalpateCamera.reading` has the pose of the wall of the newest image.
    markers, lens, unit, rest_images
        As in `palpate.sensor.SensorLaunchSpec`; the first images show the untouched dome.
    color_mode
        Order of the colours; a grey image has three that are the same.
    warmup_s
        Longest time to wait for the first image.
    """

    source: str = "0"
    twin: str = ""
    markers: int = 169
    lens: str = ""
    unit: str = ""
    rest_images: int = 1
    color_mode: ColorMode = ColorMode.RGB
    warmup_s: float = 5.0

    def __post_init__(self) -> None:
        self.color_mode = ColorMode(self.color_mode)
        if self.warmup_s <= 0:
            raise ValueError(f"`warmup_s` is {self.warmup_s:g}. Give some seconds.")
