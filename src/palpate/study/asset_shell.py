"""The surface of a skin as triangles: outer and inner side, and the ring of the base between them."""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray, IntArray
from palpate.design import Skin, SurfaceMesh

RINGS, SECTORS = 48, 144
"""Rings from apex to rim, and corners of each: 0.006 mm from the surface of a dome of 20 mm."""


def skin_surface(skin: Skin) -> SurfaceMesh:
    """Closed surface of a skin, its base at z = 0."""
    outer, inner = (_sheet(skin, layer) for layer in (1.0, 0.0))
    up = _triangles()
    rim = 1 + (RINGS - 1) * SECTORS + np.arange(SECTORS)
    below = _band(rim, rim + len(outer))
    return SurfaceMesh(np.concatenate([outer, inner]), np.concatenate([up, up[:, ::-1] + len(outer), below]))


def _sheet(skin: Skin, layer: float) -> FloatArray:
    """Points (1 + `RINGS` `SECTORS`, 3) mm of one side: the apex, then ring by ring."""
    angle = 2.0 * np.pi * np.arange(SECTORS) / SECTORS
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    disc = np.concatenate([np.zeros((1, 2)), *(circle * (ring / RINGS) for ring in range(1, RINGS + 1))])
    return skin.point(disc, layer)


def _triangles() -> IntArray:
    """Triangles of a sheet, counter-clockwise seen from above."""
    first = 1 + np.arange(SECTORS)
    cap = np.stack([np.zeros_like(first), first, np.roll(first, -1)], axis=-1)
    bands = [_band(first + ring * SECTORS, first + (ring + 1) * SECTORS) for ring in range(RINGS - 1)]
    return np.concatenate([cap, *bands])


def _band(one: IntArray, other: IntArray) -> IntArray:
    """Triangles between two closed rows of points."""
    after, beyond = np.roll(one, -1), np.roll(other, -1)
    return np.concatenate([np.stack([one, other, beyond], axis=-1), np.stack([one, beyond, after], axis=-1)])
