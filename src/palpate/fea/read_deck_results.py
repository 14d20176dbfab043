"""Reading of CalculiX results: the text results (.dat) by increment, and the counts of its log.

A block of a ``.dat`` file is a line of text that ends with the time, then rows of numbers::

     displacements (vx,vy,vz) for set DOME_NODES and time  0.8000000E+00

             1  0.000000E+00  0.000000E+00  0.000000E+00
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from palpate.core import FloatArray
from palpate.mechanics import von_mises

_TITLE = re.compile(r"^\s*(\w[\w ]*?)\s*\(.*for set (\w+) and time\s+([\d.E+-]+)", re.IGNORECASE)
_QUANTITIES = ("displacements", "total force", "stresses")
_STRESS = (2, 3, 4, 5, 7, 6)
"""Columns of xx, yy, zz, xy, yz, zx in a row of stresses, which has xz before yz."""
_LETTERS = re.compile(r"[A-DF-Za-df-z]")
_EQUATIONS = re.compile(r"number of equations\s+(\d+)")


@dataclass(frozen=True)
class Block:
    """One block of a ``.dat`` file: ``rows`` (n, k) as printed.

    `quantity`, `members` and `time` are e.g. ``displacements`` of ``DOME_NODES`` at 0.8 (mm of depth).
    """

    quantity: str
    members: str
    time: float
    rows: FloatArray


@dataclass(frozen=True)
class CalculixIncrements:
    """Increments in the results of CalculiX.

    Attributes
    ----------
    depth
        (n,) mm depth of the wall.
    displacement
        (n, n_nodes, 3) mm; nan at nodes that were not printed.
    wall_force
        (n, 3) N of the modelled part on the wall.
    peak_stress
        (n,) MPa maximum von Mises stress at an integration point.
    """

    depth: FloatArray
    displacement: FloatArray
    wall_force: FloatArray
    peak_stress: FloatArray


def read_increments(path: Path, nodes: int) -> CalculixIncrements:
    """Read the increments of a ``.dat`` file.

    `nodes` is the number of nodes of the palpate mesh; its node k is k + 1 in the file. An incomplete increment is
    left out; a missing file counts as empty.
    """
    found: dict[float, dict[str, FloatArray]] = {}
    for block in read_blocks(path):
        found.setdefault(block.time, {})[block.quantity] = block.rows
    whole = {time: blocks for time, blocks in sorted(found.items()) if {*blocks} >= {*_QUANTITIES}}
    displacement = np.full((len(whole), nodes, 3), np.nan)
    for k, blocks in enumerate(whole.values()):
        rows = blocks["displacements"]
        displacement[k, rows[:, 0].astype(int) - 1] = rows[:, 1:4]
    return CalculixIncrements(
        depth=np.array([*whole]),
        displacement=displacement,
        wall_force=-np.array([blocks["total force"][0] for blocks in whole.values()]).reshape(-1, 3),
        peak_stress=np.array([von_mises(blocks["stresses"][:, _STRESS]).max() for blocks in whole.values()]),
    )


def read_blocks(path: Path) -> Iterator[Block]:
    """Yield the blocks of a ``.dat`` file in order; nothing if the file is missing."""
    title: re.Match[str] | None = None
    rows: list[list[float]] = []
    for line in path.read_text().splitlines() if path.is_file() else []:
        new = _TITLE.match(line)
        if new is not None or _LETTERS.search(line):
            if title is not None and rows:
                yield Block(title[1], title[2], float(title[3]), np.array(rows))
            title, rows = new, []
        elif title is not None and line.strip():
            rows.append([float(word) for word in line.split()])
    if title is not None and rows:
        yield Block(title[1], title[2], float(title[3]), np.array(rows))


def read_counts(log: Path, convergence: Path) -> tuple[int, int]:
    """Read the number of unknowns (log) and of Newton iterations (``.cvg``); 0 if not found."""
    equations = _EQUATIONS.search(log.read_text(errors="replace")) if log.is_file() else None
    lines = convergence.read_text().splitlines() if convergence.is_file() else []
    iterations = sum(line.split()[:1] != [] and line.split()[0].isdigit() for line in lines)
    return int(equations[1]) if equations else 0, iterations
