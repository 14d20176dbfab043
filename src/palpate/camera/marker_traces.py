"""Printed dots and their traces in an image.

The centre of a trace is not the projection of the centre of its dot: a disc of radius ρ tilted by t at distance Z
appears as an ellipse whose centre lies f ρ² sin t cos t / Z² further to the side that is nearer, and where the skin
is bent, or stretched unevenly, it lies elsewhere again.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from palpate.camera.arrays import array_module
from palpate.camera.camera import Camera
from palpate.camera.surface import Surface
from palpate.core import FloatArray

_EDGE_POINTS = 32


def edge_offsets(radius: float, count: int = _EDGE_POINTS) -> FloatArray:
    """(k, 2) corners of a polygon with the area of a disc of `radius` mm, in its plane."""
    angle = 2.0 * np.pi * np.arange(count) / count
    grown = radius * np.sqrt(np.pi / (count / 2.0 * np.sin(2.0 * np.pi / count)))
    return grown * np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def flat_marker_outlines(
    centres: FloatArray, normals: FloatArray, diameter: float, corners: int = _EDGE_POINTS
) -> FloatArray:
    """Edges of flat discs tangent to a surface.

    Parameters
    ----------
    centres, normals
        (m, 3) mm and unit vectors.
    diameter
        Of a dot, mm.
    corners
        Of the polygons of the same area that stand for discs.

    Returns
    -------
    ndarray
        (m, k, 3) mm.

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
    """Edges of round dots that lie on the inner surface of a skin.

    Parameters
    ----------
    skin
        The skin.
    centres
        (m, 3) mm, on its inner surface.
    diameter, corners
        As for `flat_marker_outlines`.

    Returns
    -------
    ndarray
        (m, k, 3) mm.
    """
    return skin.nearest(flat_marker_outlines(centres, skin.normal(centres), diameter, corners))


def tangent_pair(normals: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors (m, 3) each, at right angles to unit normals (m, 3) and to one another.

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
    """Centroids (m, 2) px of the traces of dots, and diameters (m,) px of discs as large as they are."""

    centres: FloatArray
    diameters: FloatArray


def project_markers(camera: Camera, edges: FloatArray) -> MarkerTraces:
    """Traces of markers with outlines (..., m, k, 3) mm, arrays or tensors; centres are (..., m, 2)."""
    pixels = camera.project(edges)
    module, x, y = array_module(pixels), pixels[..., 0], pixels[..., 1]
    nx, ny = module.roll(x, -1, -1), module.roll(y, -1, -1)
    cross = x * ny - nx * y
    twice = cross.sum(axis=-1)
    moments = module.stack([((x + nx) * cross).sum(axis=-1), ((y + ny) * cross).sum(axis=-1)], axis=-1)
    return MarkerTraces(moments / (3.0 * twice[..., None]), module.sqrt(2.0 * abs(twice) / np.pi))
