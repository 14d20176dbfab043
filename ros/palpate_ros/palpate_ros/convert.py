"""Messages of palpate as objects of ROS, as rclpy's checks want their fields."""

from __future__ import annotations

from array import array
from importlib import import_module
from typing import Any

import numpy as np


def message_type(kind: str) -> Any:
    """The class of a message type such as ``geometry_msgs/msg/Pose``."""
    package, _, name = kind.split("/")
    return getattr(import_module(f"{package}.msg"), name)


def make_message(kind: str, fields: dict[str, Any]) -> Any:
    """An object of a message type."""
    type_ = message_type(kind)
    kinds = type_.get_fields_and_field_types()
    return type_(**{name: _fitting(value, kinds[name]) for name, value in fields.items()})


def _fitting(value: Any, kind: str) -> Any:
    """A field's value: sequences of numbers as arrays, bytes as bytes; the rest, and arrays of a length, as it is."""
    if kind == "octet":
        return bytes([value])
    if isinstance(value, np.ndarray) and kind.startswith("sequence"):
        return array(value.dtype.char, value.tobytes())
    return value
