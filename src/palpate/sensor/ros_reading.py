"""Messages of poses, forces and markers in the sensor's frame (docs/mount.md): metres, radians, N."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from palpate.core import BoolArray, FloatArray
from palpate.sensor.ros_message import Message

_IN_POSE, _UNITS = [3, 4, 2], np.array([np.pi / 180, np.pi / 180, -1e-3])
"""Indices of rx, ry, depth in (x, y, z, rotations about them), and their units; z is minus depth."""
_UINT32, _FLOAT32 = 6, 7
"""Types of `sensor_msgs/PointField`."""
_POINT = np.dtype([("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("id", "<u4"), ("seen", "<u4")])


def pose_message(tilt_deg: Iterable[float], place_mm: Iterable[float], depth_mm: float) -> Message:
    """Build an obstacle's pose: rotation (rx, ry) as a quaternion, position (x, y), z below first contact."""
    rotation = np.radians(np.array([*tilt_deg, 0.0]))
    angle = float(np.linalg.norm(rotation))
    turned = _xyz("geometry_msgs/msg/Quaternion", 0.5 * np.sinc(angle / (2.0 * np.pi)) * rotation)
    turned.fields["w"] = float(np.cos(angle / 2.0))
    place = _xyz("geometry_msgs/msg/Point", np.array([*place_mm, -depth_mm]) / 1e3)
    return Message("geometry_msgs/msg/Pose", {"position": place, "orientation": turned})


def pose_stamped(pose: Message, header: Message) -> Message:
    """Add a header to a pose."""
    return Message("geometry_msgs/msg/PoseStamped", {"header": header, "pose": pose})


def pose_with_covariance(pose: Message, covariance: FloatArray, header: Message) -> Message:
    """Build a wall's pose with the covariance (3, 3) of rx, ry (degrees) and depth (mm); 0 elsewhere."""
    wide = np.zeros((6, 6))
    wide[np.ix_(_IN_POSE, _IN_POSE)] = covariance * np.outer(_UNITS, _UNITS)
    inner = Message("geometry_msgs/msg/PoseWithCovariance", {"pose": pose, "covariance": wide.ravel()})
    return Message("geometry_msgs/msg/PoseWithCovarianceStamped", {"header": header, "pose": inner})


def wrench_stamped(force: FloatArray, header: Message) -> Message:
    """Build the message of a force (3,) N on the wall; its torque is unknown and set to 0."""
    parts = {"force": force, "torque": np.zeros(3)}
    vectors = {name: _xyz("geometry_msgs/msg/Vector3", each) for name, each in parts.items()}
    wrench = Message("geometry_msgs/msg/Wrench", vectors)
    return Message("geometry_msgs/msg/WrenchStamped", {"header": header, "wrench": wrench})


def dots_message(positions: FloatArray, seen: BoolArray, header: Message) -> Message:
    """Build the message of marker positions (m, 3) mm: ``id`` is the layout index, ``seen`` 1 if found."""
    cloud = np.zeros(len(positions), _POINT)
    cloud["x"], cloud["y"], cloud["z"] = positions.T / 1e3
    cloud["id"], cloud["seen"] = np.arange(len(positions)), seen
    kinds = [_FLOAT32 if name in "xyz" else _UINT32 for name in _POINT.names or ()]
    parts = [
        Message("sensor_msgs/msg/PointField", {"name": name, "offset": 4 * k, "datatype": kinds[k], "count": 1})
        for k, name in enumerate(_POINT.names or ())
    ]
    fields = {
        "header": header,
        "height": 1,
        "width": len(cloud),
        "fields": parts,
        "is_bigendian": False,
        "point_step": _POINT.itemsize,
        "row_step": _POINT.itemsize * len(cloud),
        "data": cloud.view(np.uint8),
        "is_dense": bool(np.isfinite(positions).all()),
    }
    return Message("sensor_msgs/msg/PointCloud2", fields)


def _xyz(kind: str, values: FloatArray) -> Message:
    return Message(kind, dict(zip("xyz", values.tolist(), strict=True)))
