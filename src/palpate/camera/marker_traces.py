"""Printed markers and their traces: the areas that they cover in an image.

The centroid of a trace is not the projection of the marker's centre: a disc of radius ρ tilted by t at distance Z
appears as an ellipse whose centre is displaced by f ρ² sin t cos t / Z² towards the closer side. Curvature and uneven
stretch of the skin displace it too.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from palpate.camera.arrays import array_module
from palpate.camera.camera import Camera
from palpate.camera.surface import Surface
from palpate.core import FloatArray

_EDGE_POINTS = 32
"""Corners of a marker's outline, a polygon of the area of the disc."""


def edge_offsets(radius: float, count: int = _EDGE_POINTS) -> FloatArray:
    """Return the corners (k, 2) of a polygon with the area of a disc of `radius` mm, in its plane."""
    angle = 2.0 * np.pi * np.arange(count) / count
    grown = radius * np.sqrt(np.pi / (count / 2.0 * np.sin(2.0 * np.pi / count)))
    return grown * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def flat_marker_outlines(
    centres: FloatArray, normals: FloatArray, diameter: float, corners: int = _EDGE_POINTS
) -> FloatArray:
    """Return the outlines (m, k, 3) mm of flat discs tangent to a surface.

    Parameters
    ----------
    centres, normals
        (m, 3) mm and unit vectors.
    diameter
        Diameter of a marker, mm.
    corners
        Number of corners of the polygons, which have the area of the discs.

    Examples
    --------
    >>> edges = flat_marker_outlines(np.array([[0.0, 0.0, 20.0]]), np.array([[0.0, 0.0, 1.0]]), diameter=2.0)
    >>> float(np.linalg.norm(edges[0] - [0, 0, 20], axis=1).max().round(3))
    1.003
    """
    first, second = tangent_pair(normals)
    flat = edge_offsets(diameter / 2.0, corners)
    edges: FloatArray = centres[:, None] + flat[:, :1] * first[:, None] + flat[:, 1:] * second[:, None]
    return edges


def marker_outlines(skin: Surface, centres: FloatArray, diameter: float, corners: int = _EDGE_POINTS) -> FloatArray:
    """Return the outlines (m, k, 3) mm of round markers on the inner surface of a skin.

    `centres` (m, 3) mm are on this surface; `diameter` and `corners` are as for `flat_marker_outlines`.
    """
    return skin.nearest(flat_marker_outlines(centres, skin.normal(centres), diameter, corners))


def tangent_pair(normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return two unit vectors (m, 3) each, orthogonal to unit normals (m, 3) and to one another.

    Examples
    --------
    >>> first, second = tangent_pair(np.array([[0.0, 0.0, 1.0]]))
    >>> float(first[0] @ second[0]), float(first[0, 2])
    (0.0, 0.0)
    """
    aside = np.where(np.abs(normals[:, :1]) < 0.9, [[1.0, 0.0, 0.0]], [[0.0, 1.0, 0.0]])
    first = np.cross(normals, aside)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return first, np.cross(normals, first)


class MarkerTraces(NamedTuple):
    """Centroids (m, 2) px of the traces of markers, and diameters (m,) px of discs of equal area."""

    centres: FloatArray
    diameters: FloatArray


def project_markers(camera: Camera, edges: FloatArray) -> MarkerTraces:
    """Return the traces (..., m) of markers with outlines (..., m, k, 3) mm, arrays or tensors."""
    pixels = camera.project(edges)
    module, x, y = array_module(pixels), pixels[..., 0], pixels[..., 1]
    nx, ny = module.roll(x, -1, -1), module.roll(y, -1, -1)
    cross = x * ny - nx * y
    twice = cross.sum(axis=-1)
    moments = module.stack([((x + nx) * cross).sum(axis=-1), ((y + ny) * cross).sum(axis=-1)], axis=-1)
    return MarkerTraces(moments / (3.0 * twice[..., None]), module.sqrt(2.0 * abs(twice) / np.pi))
