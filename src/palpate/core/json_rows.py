"""Rows of a table in JSON values of several shapes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any


def flatten(row: Mapping[str, Any]) -> dict[str, Any]:
    """Flatten a nested row: ``{"pose": [1, 2]}`` gives ``pose_0`` and ``pose_1``."""
    flat: dict[str, Any] = {}
    for key, value in row.items():
        if isinstance(value, Mapping):
            flat |= {f"{key}_{inner}": cell for inner, cell in flatten(value).items()}
        elif isinstance(value, list):
            flat |= flatten({f"{key}_{number}": cell for number, cell in enumerate(value)})
        else:
            flat[key] = value
    return flat


def load_rows(data: bytes) -> list[Any] | None:
    """Rows of one JSON value: a list, alone or in an object, lists as columns, or an object an image."""
    try:
        value = json.loads(data)
    except ValueError:
        return None  # one object on each line
    if not isinstance(value, dict):
        return value if isinstance(value, list) else None
    inner = list(value.values())
    if len(inner) > 1 and all(isinstance(one, dict) for one in inner):
        if all(list(one) == [str(at) for at in range(len(inner[0]))] for one in inner):  # columns of pandas
            inner = [list(one.values()) for one in inner]
        else:
            return [{"image": name, **row} for name, row in value.items()]
    if inner and all(isinstance(one, list) and len(one) == len(inner[0]) for one in inner):
        return [dict(zip(value, row, strict=True)) for row in zip(*inner, strict=True)]
    tables = [one for one in inner if isinstance(one, list) and one and all(isinstance(row, dict) for row in one)]
    lists = [one for one in inner if isinstance(one, list)]
    alone = len(tables) == len(lists) == 1 and not any("unit" in str(key).lower() for key in value)
    return tables[0] if alone else [value]
