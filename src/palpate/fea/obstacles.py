"""Obstacles by name: the package's own, and those of installed packages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import ValidationError

from palpate.core import PalpateError, Registry
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


def read_obstacle(text: str, travel: ObstacleSpec) -> ObstacleSpec:
    """Read an obstacle from words, ``KIND`` or ``KIND:NAME=VALUE,…``, with travel and contact law of another.

    Raises
    ------
    PalpateError
        If it is not written so, or is no obstacle.

    Examples
    --------
    >>> from palpate.fea import WallSpec
    >>> read_obstacle("ball:radius=8,offset=2", WallSpec(depth=3)).words
    'ball 8 mm, 2 mm off the axis'
    """
    kind, _, rest = text.partition(":")
    pairs = [item.partition("=") for item in rest.split(",") if item]
    if any(not mark or not name for name, mark, _ in pairs):
        raise PalpateError(f"The obstacle '{text}' is not written as KIND:NAME=VALUE.", "Write ball:radius=8.")
    own = {name: getattr(travel, name) for name in ObstacleSpec.model_fields}
    if kind == "wall":
        return type(travel).model_validate(travel.model_dump() | {name.strip(): value for name, _, value in pairs})
    try:
        return obstacle_from_data({"kind": kind, **own, **{name.strip(): value for name, _, value in pairs}})
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise PalpateError(
            f"The obstacle's {where or 'numbers'}: {first['msg']}.",
            f"Its numbers are {', '.join(name for name in OBSTACLES.get(kind).model_fields if name != 'kind')}.",
        ) from None
