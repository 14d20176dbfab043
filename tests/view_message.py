"""Reader of the binary messages that the viewer sends to the browser."""

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray


def read_message(data: bytes) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Meta data and arrays of a message of `palpate.viewer.message`."""
    size = int.from_bytes(data[:4], "little")
    head = json.loads(data[4 : 4 + size])
    arrays = {}
    for name, (kind, offset, shape) in head["arrays"].items():
        start = 4 + size + offset
        count = int(np.prod(shape))
        arrays[name] = np.frombuffer(data, f"<{kind}", count, start).reshape(shape)
    return head["meta"], arrays
