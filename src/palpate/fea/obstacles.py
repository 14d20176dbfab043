"""Registry of obstacles: those of palpate, and those of installed packages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from palpate.core import Registry, data_from_text, spec_from_data
from palpate.fea.spec import ObstacleSpec

OBSTACLES: Registry[type[ObstacleSpec]] = Registry(
    "palpate.obstacles",
    "obstacle",
    {
        "wall": "palpate.fea.wall:WallSpec",
        "ball": "palpate.fea.ball:BallSpec",
        "cylinder": "palpate.fea.cylinder:CylinderSpec",
        "edge": "palpate.fea.edge:EdgeSpec",
        "plate": "palpate.fea.plate:PlateSpec",
        "route": "palpate.fea.route:RouteSpec",
        "side_wall": "palpate.fea.side_wall:SideWallSpec",
    },
    lambda found: isinstance(found, type) and issubclass(found, ObstacleSpec),
)
"""Obstacle specs by their `kind`; files without a kind contain a wall."""


def obstacle_from_data(data: Mapping[str, Any]) -> ObstacleSpec:
    """Read an obstacle's spec from plain values; without a ``kind`` it is a flat wall.

    Raises
    ------
    PalpateError
        If the kind is unknown, or a number is missing, unknown or out of bounds.
    """
    return spec_from_data(OBSTACLES, data, "wall")


def read_obstacle(text: str, travel: ObstacleSpec) -> ObstacleSpec:
    """Read an obstacle from ``KIND`` or ``KIND:NAME=VALUE,…``, with depth and contact law of `travel`.

    Raises
    ------
    PalpateError
        If the text has another form, or is not an obstacle.

    Examples
    --------
    >>> from palpate.fea import WallSpec
    >>> read_obstacle("ball:radius=8,offset=2", WallSpec(depth=3)).label
    'ball 8 mm, 2 mm off the axis'
    """
    words = data_from_text("obstacle", text)
    shared = type(travel) if words["kind"] == "wall" else ObstacleSpec
    own = {name: getattr(travel, name) for name in shared.model_fields}
    return obstacle_from_data(own | words)
