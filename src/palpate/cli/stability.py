"""`palpate stability`: the flat and the inverted state of a dome, by depth and tilt."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np
from cyclopts import Parameter

from palpate.cli.compiling import announce_compilation
from palpate.cli.flag import JsonFlag
from palpate.cli.output import print_json, print_table
from palpate.cli.press import WallPressFlags
from palpate.fea import Stability, find_stability

_TILTS = "Tilts in deg that are followed; without it, the one of --tilt."


def stability(
    *,
    flags: WallPressFlags = WallPressFlags(),
    tilts: Annotated[tuple[float, ...], Parameter(help=_TILTS, consume_multiple=True)] = (),
    json: JsonFlag = False,
) -> None:
    """Follow both stable states of a dome: where the inverted one exists, where the flat one ends, their energy."""
    walls = [flags.wall.model_validate({**dict(flags.wall), "tilt_deg": tilt}) for tilt in tilts] or [flags.wall]
    mesh, material, _ = flags.problem()
    announce_compilation()
    found = [find_stability(mesh, material, wall) for wall in walls]
    if json:
        print_json([describe_stability(one) for one in found])
        return
    for one in found:
        _print_stability(one)


def describe_stability(found: Stability) -> dict[str, Any]:
    """Both states of a dome under one tilt as JSON data; nan where a number does not exist."""
    columns = {
        "depth_mm": found.depth,
        "flat_energy_mj": found.flat_energy,
        "inverted_energy_mj": found.inverted_energy,
        "flat_force_n": found.flat_force,
        "inverted_force_n": found.inverted_force,
    }
    return {
        "tilt_deg": found.obstacle.radial,
        "inverted_from_mm": found.inverted_from,
        "flat_to_mm": found.flat_to,
        "message": found.message,
        "depths": [{name: float(values[i]) for name, values in columns.items()} for i in range(len(found.depth))],
    }


def _print_stability(found: Stability) -> None:
    rows = [
        [f"{row['depth_mm']:.2f}", *(_text(row[name]) for name in list(row)[1:])]
        for row in describe_stability(found)["depths"]
    ]
    columns = ["depth mm", "flat mJ", "inverted mJ", "flat N", "inverted N"]
    print_table(f"tilt {found.obstacle.radial:g}°", columns, rows)
    print(found.message)


def _text(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.4f}"
