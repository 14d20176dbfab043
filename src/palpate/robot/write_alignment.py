"""Alignments as plain data: touches as a table, and how all came about."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from palpate.core import atomic_write, provenance
from palpate.core.report import write_csv
from palpate.robot.alignment import Alignment
from palpate.robot.play import AlignmentTrial

COLUMNS = (
    "touch",
    "rx_deg",
    "ry_deg",
    "depth_mm",
    "angle_deg",
    "half_width_deg",
    "turned_deg",
    "force_n",
    "force_upper_n",
    "friction",
    "images",
)


def list_touches(alignment: Alignment) -> list[dict[str, Any]]:
    """A row a touch, by `COLUMNS`; friction is empty where nothing slips."""
    columns = zip(
        alignment.touches, alignment.angles_deg, alignment.half_widths_deg, alignment.turned_deg, strict=True
    )
    return [
        {
            "touch": number,
            "rx_deg": float(touch.tilt_deg[0]),
            "ry_deg": float(touch.tilt_deg[1]),
            "depth_mm": touch.depth,
            "angle_deg": angle,
            "half_width_deg": half,
            "turned_deg": turned,
            "force_n": touch.force_n,
            "force_upper_n": touch.force_upper_n,
            "friction": 1.0 / touch.inverse_friction if touch.inverse_friction > 0 else None,
            "images": touch.images,
        }
        for number, (touch, angle, half, turned) in enumerate(columns, start=1)
    ]


def list_wall_touches(walls: Sequence[AlignmentTrial]) -> list[dict[str, Any]]:
    """A row a touch of every wall, by ``wall`` (from 1) and `COLUMNS`."""
    return [{"wall": number, **row} for number, wall in enumerate(walls, 1) for row in list_touches(wall.alignment)]


def describe_alignment(alignment: Alignment) -> dict[str, Any]:
    """How an alignment ended, and what is left, as plain data."""
    known = math.isfinite(alignment.residual_deg)
    return {
        "square": alignment.square,
        "outcome": alignment.outcome.name.lower(),
        "reason": str(alignment.outcome),
        "touches": len(alignment.touches),
        "images": alignment.images,
        "residual_deg": alignment.residual_deg if known else None,
        "residual_half_width_deg": alignment.residual_half_width_deg if known else None,
    }


def describe_wall(wall: AlignmentTrial) -> dict[str, Any]:
    """A wall that was played, with the truth, as plain data."""
    said = wall.alignment
    return {
        "tilt_deg": wall.tilt_deg,
        "friction": wall.friction,
        **describe_alignment(said),
        "final_deg": wall.final_deg,
        "max_force_n": wall.max_force_n,
        "held": bool(wall.final_deg <= said.residual_deg + said.residual_half_width_deg),
    }


def write_alignments(folder: Path, walls: Sequence[AlignmentTrial], facts: dict[str, Any]) -> None:
    """Write ``touches.csv``, a row a touch, and ``alignment.json``, a wall an entry with `facts` and versions.

    Raises
    ------
    PalpateError
        If a file cannot be written.
    """
    folder.mkdir(parents=True, exist_ok=True)
    write_csv(folder / "touches.csv", list_wall_touches(walls), ["wall", *COLUMNS])
    content = facts | {"walls": [describe_wall(wall) for wall in walls], "made_by": provenance()}
    with atomic_write(folder / "alignment.json") as draft:
        draft.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
