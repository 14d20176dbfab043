"""Binary message of arrays for the browser: a JSON header, then their bytes.

4 bytes    length n of the head, little-endian
n bytes    JSON: {"meta": …, "arrays": {name: [kind, offset, [shape]]}}, padded with blanks to a multiple of 4
…          float32 or uint32, little-endian, each at its offset behind the head
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray


def write_message(meta: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Write one message.

    Parameters
    ----------
    meta
        JSON data.
    arrays
        Real arrays become float32, integers and truths uint32.
    """
    parts, places, offset = [], {}, 0
    for name, values in arrays.items():
        real = np.issubdtype(values.dtype, np.floating)
        part = np.ascontiguousarray(values, "<f4" if real else "<u4").tobytes()
        places[name] = ["f4" if real else "u4", offset, list(values.shape)]
        parts.append(part)
        offset += len(part)
    head = json.dumps({"meta": dict(meta), "arrays": places}, allow_nan=False).encode()
    head += b" " * (-len(head) % 4)
    return b"".join([len(head).to_bytes(4, "little"), head, *parts])
