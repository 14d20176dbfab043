"""Messages of ROS 2 as plain values, whoever sends or writes them.

A `Message` names its type and holds its fields as numbers, texts, numpy arrays, lists and further messages;
`build_message` makes the objects of any library of it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple


class Message(NamedTuple):
    """A message.

    Attributes
    ----------
    kind
        As rosbags writes it: ``geometry_msgs/msg/Pose``.
    fields
        Values by name: numbers, texts, arrays, messages, and lists of messages.
    """

    kind: str
    fields: dict[str, Any]


def build_message(message: Message, make: Callable[[str, dict[str, Any]], Any]) -> Any:
    """The object of a message: `make` is called by kind and fields for every message in it, inner ones first.

    Examples
    --------
    >>> build_message(header_of(1_500_000_000, "dome"), lambda kind, fields: fields)
    {'stamp': {'sec': 1, 'nanosec': 500000000}, 'frame_id': 'dome'}
    """

    def built(value: Any) -> Any:
        if isinstance(value, Message):
            return build_message(value, make)
        return [built(each) for each in value] if isinstance(value, list) else value

    return make(message.kind, {name: built(value) for name, value in message.fields.items()})


def header_of(now: int, frame: str) -> Message:
    """Header of a time in ns and a frame."""
    stamp = Message("builtin_interfaces/msg/Time", {"sec": now // 10**9, "nanosec": now % 10**9})
    return Message("std_msgs/msg/Header", {"stamp": stamp, "frame_id": frame})
