"""The two stable branches of a pressed dome: onset of the inverted, end of the flat one, and energy.

Beyond a depth of some 2.6 thicknesses, a dome has two equilibria at the same wall: its apex flat on the wall, or
inverted and in contact on a ring. A design used at larger depths has two marker maps for one pose. The inverted
branch is found from the mirror image of the skin beyond the wall and followed to its end (`palpate.fea.inverted`).
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
    """Both branches of one dome at one tilt, at the depths of the increments.

    Attributes
    ----------
    obstacle
        Tilt, maximum depth, depth step and contact law.
    depth
        (n,) mm.
    flat_energy, inverted_energy
        (n,) mJ stored in the whole dome; nan if the branch does not exist or was not found.
    flat_force, inverted_force
        (n,) N along the dome's axis; nan as the energy.
    inverted_from
        Depth in mm from which the inverted branch exists; nan if it was not found.
    flat_to
        Depth in mm at which the flat branch ends; nan if it reaches the maximum depth.
    message
        Summary in one sentence.
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
    """Follow the flat and the inverted branch of a dome; parameters as for `solve_press`.

    The result is given at the depths of the increments on either branch, without rest.
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
    """Return the values (n,) of a branch at these depths; nan if it does not reach a depth."""
    result = np.full(len(depth), np.nan)
    for at, value, label in zip(press.depth, values, press.branch, strict=True):
        if label == branch:
            result[np.abs(depth - at) < 1e-6] = value
    return result


def _describe(start: float, end: float, deepest: float) -> str:
    if np.isnan(start):
        return f"Only the flat branch was found up to {deepest:.3g} mm."
    text = f"An inverted branch exists from {start:.3g} mm"
    return f"{text}." if np.isnan(end) else f"{text}; the flat branch ends at {end:.3g} mm."
