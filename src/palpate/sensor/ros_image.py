"""Messages of images, calibrations and the state of a camera."""

from __future__ import annotations

from collections.abc import Mapping
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.camera import Camera
from palpate.sensor.ros_message import Message


class Level(IntEnum):
    """Severity of a state, as in `diagnostic_msgs/DiagnosticStatus`."""

    OK = 0
    WARN = 1
    ERROR = 2


def image_message(image: NDArray[Any], header: Message) -> Message:
    """Build the message of an 8-bit image (h, w) or (h, w, 3) blue, green, red."""
    pixels = np.ascontiguousarray(image, np.uint8)
    fields = {
        "header": header,
        "height": pixels.shape[0],
        "width": pixels.shape[1],
        "encoding": "mono8" if pixels.ndim == 2 else "bgr8",
        "is_bigendian": 0,
        "step": pixels.strides[0],
        "data": pixels.ravel(),
    }
    return Message("sensor_msgs/msg/Image", fields)


def camera_info(camera: Camera, header: Message) -> Message:
    """Build a calibration message; the rectified image has the same focal lengths and centre."""
    spec, region = camera.spec, dict.fromkeys(("x_offset", "y_offset", "height", "width"), 0)
    k = np.array([[spec.fx_px, 0.0, spec.cx_px], [0.0, spec.fy_px, spec.cy_px], [0.0, 0.0, 1.0]])
    fields = {
        "header": header,
        "height": spec.height_px,
        "width": spec.width_px,
        "distortion_model": camera.lens.model or camera.lens.name,
        "d": np.array(camera.lens.coefficients),
        "k": k.ravel(),
        "r": np.eye(3).ravel(),
        "p": np.column_stack([k, np.zeros(3)]).ravel(),
        "binning_x": 0,
        "binning_y": 0,
        "roi": Message("sensor_msgs/msg/RegionOfInterest", {**region, "do_rectify": False}),
    }
    return Message("sensor_msgs/msg/CameraInfo", fields)


def diagnostics(level: Level, name: str, says: str, values: Mapping[str, str], header: Message) -> Message:
    """Build the message of the state of one part."""
    status = {
        "level": int(level),
        "name": name,
        "message": says,
        "hardware_id": name,
        "values": [Message("diagnostic_msgs/msg/KeyValue", {"key": key, "value": at}) for key, at in values.items()],
    }
    fields = {"header": header, "status": [Message("diagnostic_msgs/msg/DiagnosticStatus", status)]}
    return Message("diagnostic_msgs/msg/DiagnosticArray", fields)
