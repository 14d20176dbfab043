"""Interface of a skin for a camera."""

from __future__ import annotations

from typing import Protocol

from palpate.core import FloatArray


class Surface(Protocol):
    """Inner surface of a skin; `palpate.design.Skin` is one."""

    base_radius: float
    """Radius of the opening in the base plane, mm."""

    def nearest(self, points: FloatArray) -> FloatArray:
        """Return the nearest points on the surface (..., 3), mm."""
        ...

    def normal(self, points: FloatArray) -> FloatArray:
        """Return outward unit normals (..., 3) at points of the surface."""
        ...
