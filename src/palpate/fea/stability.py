"""The two stable states of a pressed dome: where the inverted one exists, where the flat one ends, and their energy.

Past a travel of some 2.6 thicknesses a dome can rest in two ways against the same wall: its apex flat on the wall,
or turned inside out on a ring. A design that works deeper than that can answer one pose by two marker maps. The
inverted state is found from the mirror image of the skin beyond the wall and followed to where it ends
(`palpate.fea.inverted`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray
from palpate.fea.branch import Branch
from palpate.fea.press import Press
from palpate.fea.solve_press import solve_press
from palpate.fea.spec import ObstacleSpec
from palpate.material import Material
from palpate.mechanics import EndReason, SolverSpec
from palpate.mesh import Mesh


@dataclass(frozen=True)
class Stability:
    """Both branches of one dome under one tilt, at the depths of the increments.

    Attributes
    ----------
    obstacle
        Tilt, deepest travel, increment step and contact law.
    depth
        (n,) mm.
    flat_energy, inverted_energy
        (n,) mJ stored in the whole dome; nan where the branch does not exist or was not found.
    flat_force, inverted_force
        (n,) N along the dome's axis; nan likewise.
    inverted_from
        Depth in mm from which the inverted state exists; nan where there is none up to the deepest travel.
    flat_to
        Depth in mm at which the flat state ends; nan where it reaches the deepest travel.
    message
        One sentence for a person.
    """

    obstacle: ObstacleSpec
    depth: FloatArray
    flat_energy: FloatArray
    inverted_energy: FloatArray
    flat_force: FloatArray
    inverted_force: FloatArray
    inverted_from: float
    flat_to: float
    message: str


def find_stability(
    mesh: Mesh, material: Material, obstacle: ObstacleSpec | None = None, solver: SolverSpec | None = None
) -> Stability:
    """Follow both branches of a dome.

    Parameters
    ----------
    mesh, material, obstacle, solver
        As in `solve_press`.

    Returns
    -------
    Stability
        At the depths of the increments of the flat press, from first touch on.
    """
    flat = solve_press(mesh, material, obstacle, solver)
    inverted = solve_press(mesh, material, obstacle, solver, Branch.INVERTED)
    depth = np.union1d(np.round(flat.depth[1:], 9), np.round(inverted.depth[inverted.depth > 0], 9))
    found = inverted.branch == Branch.INVERTED
    start = float(inverted.depth[found].min()) if found.any() else float("nan")
    lost = np.isfinite(flat.jump_depth) or flat.ended not in (EndReason.DEPTH_REACHED, EndReason.WALL_AT_CLAMP)
    end = float(np.nanmin([flat.jump_depth, flat.ended_depth])) if lost else float("nan")
    return Stability(
        obstacle=flat.obstacle,
        depth=depth,
        flat_energy=_at(flat, flat.energy, Branch.FLAT, depth),
        inverted_energy=_at(inverted, inverted.energy, Branch.INVERTED, depth),
        flat_force=_at(flat, flat.force[:, 2], Branch.FLAT, depth),
        inverted_force=_at(inverted, inverted.force[:, 2], Branch.INVERTED, depth),
        inverted_from=start,
        flat_to=end,
        message=_describe(start, end, flat.ended_depth),
    )


def _at(press: Press, values: FloatArray, branch: Branch, depth: FloatArray) -> FloatArray:
    """Values (n,) of the increments of a branch at these depths; nan where it has none."""
    result = np.full(len(depth), np.nan)
    for at, value, label in zip(press.depth, values, press.branch, strict=True):
        if label == branch:
            result[np.abs(depth - at) < 1e-6] = value
    return result


def _describe(start: float, end: float, deepest: float) -> str:
    if np.isnan(start):
        return f"Up to {deepest:.3g} mm the flat state is the only one found."
    text = f"From {start:.3g} mm on an inverted state exists as well"
    return f"{text}." if np.isnan(end) else f"{text}; the flat one ends at {end:.3g} mm."
