"""Ros: standard messages of ROS 2 as plain values: what a bag holds and a node publishes, without ROS."""

from palpate.ros.message import Message, build_message, header_of
from palpate.ros.picture import Level, camera_info, diagnostics, image_message
from palpate.ros.touch import dots_message, pose_message, pose_stamped, pose_with_covariance, wrench_stamped

__all__ = [
    "Level",
    "Message",
    "build_message",
    "camera_info",
    "diagnostics",
    "dots_message",
    "header_of",
    "image_message",
    "pose_message",
    "pose_stamped",
    "pose_with_covariance",
    "wrench_stamped",
]
