"""A ball and a bar pressed into a pad that is bonded to its window, thick and thin against the contact.

Held to the integral equations of `validation.layer_theory`, which know an endless layer and small strain: the pad
is wide against its thickness, its edge free, and the obstacle's radius fifty times the contact's. A quarter of the
pad is solved under the ball, half a strip in plane strain under the bar.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from palpate.core import FloatArray
from palpate.fea import Ball, Cylinder
from palpate.mechanics import Obstacle
from palpate.verify.case import Row, compare
from palpate.verify.equilibrium import make_solid
from palpate.verify.mapped import Grid, Turn, even, join, map_block, revolve
from palpate.verify.pressing import Pressing
from palpate.verify.rubber import NEO_HOOKE
from validation.graded import graded
from validation.layer_theory import ball_on_layer, bar_on_layer

_CONTACT, _RADIUS = 1.0, 50.0
"""Radius or half width of the contact, and radius of the obstacle, mm."""
_THICK = (4.0, 2.0, 1.0)
"""Thickness of the pad over that radius of contact."""
_WIDE, _CELL = 8.0, 0.2
"""Reach of the pad over its thickness, or over half the contact if that is more; a cell under the contact, mm."""
_STIFF, _STRIP, _CLOSE = 400.0, 0.5, 2e-2


def _cuts(thickness: float) -> tuple[FloatArray, FloatArray, float]:
    """Cells from the middle outwards and from the window up, 0…1, and the pad's reach, mm."""
    reach = _WIDE * max(thickness, 0.5 * _CONTACT)
    below = 1 - graded(_CELL / thickness, 3, 3 + round(3 * thickness**0.5))[::-1] if thickness > _CONTACT else even(6)
    return graded(_CELL / reach, 8, 22), below, reach


def _press(grid: Grid, held: int, thickness: float, obstacle: Obstacle, depth: float) -> float:
    """Force (N) on a pad whose symmetry planes are x = 0 and y = 0, and the sides x of which `held` are."""
    sides = grid.near(0, 0.0) if not held else grid.near(0, 0.0) | grid.near(0, _STRIP)
    fixed = np.stack([sides, grid.near(1, 0.0), np.zeros(len(grid.nodes), bool)], axis=-1)
    fixed[grid.near(2, 0.0)] = True
    young = NEO_HOOKE.young_modulus
    pressing = Pressing(
        make_solid(grid, NEO_HOOKE, fixed),
        grid.outer_cells(grid.near(2, thickness)),
        obstacle,
        (_STIFF * young / _CONTACT, 1e-5 * _CONTACT),
        1e-6 * NEO_HOOKE.law.shear_modulus * _CONTACT**2,
        _CONTACT,
    )
    return float(pressing.follow([depth])[0].loads.force[2])


def _under_ball(thickness: float, depth: float) -> float:
    out, up, reach = _cuts(thickness)

    def section(q: FloatArray) -> FloatArray:
        return np.column_stack([reach * q[:, 0], thickness * q[:, 1]])

    grid = join(revolve(section, (out, up), Turn(2), solid=True))
    return 4 * _press(grid, 0, thickness, Ball(_RADIUS, np.array([0.0, 0.0, thickness + _RADIUS])), depth)


def _under_bar(thickness: float, depth: float) -> float:
    """Force over a mm of the bar."""
    out, up, reach = _cuts(thickness)
    strip = map_block((np.array([0.0, 1.0]), out, up), lambda q: q * [_STRIP, reach, thickness])
    bar = Cylinder(_RADIUS, np.array([0.0, 0.0, thickness + _RADIUS]), np.array([1.0, 0.0, 0.0]))
    return 2 / _STRIP * _press(join(strip), 1, thickness, bar, depth)


def pressed_pad(obstacle: str, thicker: float = 1.0) -> list[Row]:
    """Force of a ``ball`` or a ``bar`` on bonded pads of three thicknesses, over the theory's.

    Parameters
    ----------
    obstacle
        Which.
    thicker
        Factor on the thickness of ours; 1 but for a control that must not pass.
    """
    theory, ours = (ball_on_layer, _under_ball) if obstacle == "ball" else (bar_on_layer, _under_bar)
    found, exact = np.array([_compare(theory, ours, ratio * _CONTACT, thicker) for ratio in _THICK]).T
    unit = "N" if obstacle == "ball" else "N over a mm"
    return [compare(f"force, {unit}", found, exact, _CLOSE, [f"h/a = {ratio:g}" for ratio in _THICK])]


def _compare(
    theory: Callable[[float, float, float, float], tuple[float, float]],
    ours: Callable[[float, float], float],
    thickness: float,
    thicker: float,
) -> tuple[float, float]:
    """Our force and the theory's at the depth that the theory gives the contact."""
    depth, force = theory(_CONTACT, thickness, _RADIUS, NEO_HOOKE.law.shear_modulus)
    return ours(thicker * thickness, depth), force
