"""Molds of test specimens for material fits: open trays, filled and levelled with a blade.

*Tension*: the dumbbell of ASTM D412 die C (ISO 37 type 1), 3 mm thick,

      ________                 ________      25 wide at the grips
     |        \\._____________./        |    radius 14 outside, 25 inside
     |         ._____________.         |     6 wide over 33
     |________/               \\________|    115 long

*Compression*: the cylinder of ASTM D395 type 1, 29 mm across and 12.5 mm high.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from palpate.core import PalpateError, atomic_folder, provenance
from palpate.design import Arc, CadSolid, Outline, Point, box, cylinder, extrude, write_step
from palpate.fabrication.folder import hash_files
from palpate.fabrication.mesh_file import write_mesh
from palpate.fabrication.spec import ProcessSpec

LENGTH, GRIP, NARROW, NARROW_LENGTH = 115.0, 25.0, 6.0, 33.0
OUTSIDE, INSIDE, THICKNESS = 14.0, 25.0, 3.0
"""Dumbbell of ASTM D412-16 die C, mm."""
BUTTON, BUTTON_HEIGHT = 29.0, 12.5
"""Cylinder of ASTM D395-18 type 1, mm."""
_RIM, _FLOOR = 5.0, 3.0
"""Thickness of the walls between and around the hollows, and of the floor, mm."""
_MOST = 20


@dataclass(frozen=True)
class SpecimenMold:
    """Tray for several specimens, larger by the shrinkage, and one nominal specimen.

    The `name` is ``dumbbell`` or ``cylinder``.
    """

    name: str
    specimen: CadSolid
    tray: CadSolid


def build_specimen_molds(spec: ProcessSpec, count: int = 5) -> tuple[SpecimenMold, SpecimenMold]:
    """Build trays for `count` dumbbells and `count` cylinders.

    Raises
    ------
    PalpateError
        If `count` is not between 1 and 20.
    """
    if not 1 <= count <= _MOST:
        raise PalpateError(f"A tray for {count} specimens is not possible.", f"Use 1 to {_MOST}.", code="tray-count")
    scale = 1 / (1 - spec.shrinkage_percent / 100)
    return (
        SpecimenMold(
            "dumbbell",
            extrude(outline_dumbbell(), THICKNESS),
            _tray(
                lambda: extrude(outline_dumbbell(scale), scale * THICKNESS), (LENGTH, GRIP, THICKNESS), scale, count
            ),
        ),
        SpecimenMold(
            "cylinder",
            cylinder(BUTTON / 2, 0.0, BUTTON_HEIGHT),
            _tray(
                lambda: cylinder(scale * BUTTON / 2, 0.0, scale * BUTTON_HEIGHT),
                (BUTTON, BUTTON, BUTTON_HEIGHT),
                scale,
                count,
            ),
        ),
    )


def outline_dumbbell(scale: float = 1.0) -> Outline:
    """Return the outline (x, y) mm of the dumbbell about its centre; the two arcs meet smoothly."""
    rise = (GRIP - NARROW) / 2
    turn = float(np.arccos(1 - rise / (OUTSIDE + INSIDE)))
    start = NARROW_LENGTH / 2
    meet = (start + INSIDE * np.sin(turn), NARROW / 2 + INSIDE * (1 - np.cos(turn)))
    end = (start + (INSIDE + OUTSIDE) * np.sin(turn), GRIP / 2)
    half = (np.sin(turn / 2), 1 - np.cos(turn / 2))
    inside = (start + INSIDE * half[0], NARROW / 2 + INSIDE * half[1])
    outside = (end[0] - OUTSIDE * half[0], GRIP / 2 - OUTSIDE * half[1])

    def at(point: tuple[float, float], x: int, y: int) -> Point:
        return float(scale * x * point[0]), float(scale * y * point[1])

    narrow, corner = (start, NARROW / 2), (LENGTH / 2, GRIP / 2)
    return [
        at(narrow, -1, 1),
        at(narrow, 1, 1),
        Arc(at(inside, 1, 1), at(meet, 1, 1)),
        Arc(at(outside, 1, 1), at(end, 1, 1)),
        at(corner, 1, 1),
        at(corner, 1, -1),
        at(end, 1, -1),
        Arc(at(outside, 1, -1), at(meet, 1, -1)),
        Arc(at(inside, 1, -1), at(narrow, 1, -1)),
        at(narrow, -1, -1),
        Arc(at(inside, -1, -1), at(meet, -1, -1)),
        Arc(at(outside, -1, -1), at(end, -1, -1)),
        at(corner, -1, -1),
        at(corner, -1, 1),
        at(end, -1, 1),
        Arc(at(outside, -1, 1), at(meet, -1, 1)),
        Arc(at(inside, -1, 1), at(narrow, -1, 1)),
    ]


def _tray(hollow: Callable[[], CadSolid], size: tuple[float, float, float], scale: float, count: int) -> CadSolid:
    """Build a block with `count` hollows side by side along y, open at the top."""
    long, wide, high = (scale * value for value in size)
    pitch = wide + _RIM
    reach = (long / 2 + _RIM, (count * pitch + _RIM) / 2)
    block = box((-reach[0], -reach[1], -_FLOOR), (reach[0], reach[1], high))
    places = (np.arange(count) - (count - 1) / 2) * pitch
    return block.cut(*(hollow().moved(y=float(y)) for y in places))


def write_specimen_molds(folder: Path, spec: ProcessSpec, count: int = 5) -> dict[str, str]:
    """Write both trays as STEP, STL and 3MF, with a manifest, all or nothing; return SHA-256 by file.

    Raises
    ------
    PalpateError
        If the folder is not empty or cannot be written, or `count` is out of bounds.
    """
    molds = build_specimen_molds(spec, count)
    with atomic_folder(folder) as work:
        for mold in molds:
            write_step(work / f"{mold.name}.step", mold.name, {"specimen": mold.specimen, "tray": mold.tray})
            for suffix in ("stl", "3mf"):
                write_mesh(work / f"{mold.name}_tray.{suffix}", mold.tray.mesh(), mold.tray.volume)
        files = hash_files(work)
        manifest = {
            "made_by": provenance(),
            "count": count,
            "shrinkage_percent": spec.shrinkage_percent,
            "elastomer_ml": {mold.name: count * mold.specimen.volume / 1000 for mold in molds},
            "sha256": files,
        }
        (work / "manifest.json").write_text(json.dumps(manifest, indent=1) + "\n", encoding="utf-8")
    return files
