"""ROS 2 messages as plain values, independent of the library that sends or writes them.

A `Message` names its type and holds its fields as numbers, texts, numpy arrays, lists and further messages;
`build_message` converts it to the objects of any library.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple


class Message(NamedTuple):
    """ROS message: its type, such as ``geometry_msgs/msg/Pose``, and its fields by name.

    Fields are numbers, texts, arrays, messages, and lists of messages.
    """

    kind: str
    fields: dict[str, Any]


def build_message(message: Message, make: Callable[[str, dict[str, Any]], Any]) -> Any:
    """Build the object of a message: call `make` with kind and fields of all messages, inner ones first.

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
    """Build the header of a time in ns and a frame."""
    stamp = Message("builtin_interfaces/msg/Time", {"sec": now // 10**9, "nanosec": now % 10**9})
    return Message("std_msgs/msg/Header", {"stamp": stamp, "frame_id": frame})
