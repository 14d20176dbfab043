"""Obstacles by name: the package's own, and those of installed packages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from palpate.core import Registry
from palpate.fea.spec import ObstacleSpec

OBSTACLES: Registry[type[ObstacleSpec]] = Registry(
    "palpate.obstacles",
    "obstacle",
    {
        "wall": "palpate.fea.wall:WallSpec",
        "ball": "palpate.fea.ball:BallSpec",
        "cylinder": "palpate.fea.cylinder:CylinderSpec",
    },
    lambda found: isinstance(found, type) and issubclass(found, ObstacleSpec),
)
"""Obstacle specs by their `kind`; a wall, the oldest, names none in files."""


def obstacle_from_data(data: Mapping[str, Any]) -> ObstacleSpec:
    """Read an obstacle's spec from plain values; without a ``kind`` it is a flat wall.

    Raises
    ------
    PalpateError
        If there is no obstacle of that kind, or its package cannot be loaded.
    """
    return OBSTACLES.get(str(data.get("kind", "wall"))).model_validate(dict(data))
