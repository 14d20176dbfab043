"""A pressed skin as a binary glTF file.

    "glTF" 2 length | length "JSON" head | length "BIN" positions, colours, triangles

glTF has its y axis up and lengths in metres: dome (x, y, z) mm becomes (x, z, −y) / 1000.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array32 = NDArray[np.float32]

_FLOAT, _UINT = 5126, 5125
_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]) / 1000.0


@dataclass(frozen=True, eq=False)
class Part:
    """One mesh of a model.

    Attributes
    ----------
    name
        Name of the mesh.
    points
        (v, 3) mm, dome's frame.
    triangles
        (k, 3) numbers of points.
    colours
        (v, 4) red, green, blue, opacity from 0 to 1.
    """

    name: str
    points: NDArray[Any]
    triangles: NDArray[Any]
    colours: NDArray[Any]


def write_gltf(parts: Sequence[Part]) -> bytes:
    """Write parts as one binary glTF 2.0 file."""
    views: list[dict[str, Any]] = []
    accessors: list[dict[str, Any]] = []
    chunks: list[bytes] = []
    meshes = []
    for part in parts:
        points = np.ascontiguousarray(part.points @ _UP.T, "<f4")
        first = len(accessors)
        blocks = (
            (points, _FLOAT, "VEC3"),
            (np.ascontiguousarray(part.colours, "<f4"), _FLOAT, "VEC4"),
            (np.ascontiguousarray(part.triangles, "<u4").reshape(-1), _UINT, "SCALAR"),
        )
        for values, kind, shape in blocks:
            start = sum(map(len, chunks))
            chunks.append(values.tobytes())
            views.append({"buffer": 0, "byteOffset": start, "byteLength": len(chunks[-1])})
            accessors.append(
                {"bufferView": len(views) - 1, "componentType": kind, "count": len(values), "type": shape}
            )
        accessors[first] |= {"min": points.min(axis=0).tolist(), "max": points.max(axis=0).tolist()}
        primitive = {"attributes": {"POSITION": first, "COLOR_0": first + 1}, "indices": first + 2, "material": 0}
        meshes.append({"name": part.name, "primitives": [primitive]})
    body = b"".join(chunks)
    head = {
        "asset": {"version": "2.0", "generator": "palpate"},
        "scene": 0,
        "scenes": [{"nodes": list(range(len(meshes)))}],
        "nodes": [{"mesh": i, "name": mesh["name"]} for i, mesh in enumerate(meshes)],
        "meshes": meshes,
        "materials": [{"doubleSided": True, "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.8}}],
        "buffers": [{"byteLength": len(body)}],
        "bufferViews": views,
        "accessors": accessors,
    }
    text = json.dumps(head).encode()
    text += b" " * (-len(text) % 4)
    size = 12 + 8 + len(text) + 8 + len(body)
    return b"".join(
        [
            b"glTF",
            (2).to_bytes(4, "little"),
            size.to_bytes(4, "little"),
            len(text).to_bytes(4, "little") + b"JSON" + text,
            len(body).to_bytes(4, "little") + b"BIN\0" + body,
        ]
    )
