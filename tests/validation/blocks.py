"""A rubber disc bonded between plates: far stiffer than the rubber, by its shape.

With the shape factor S, loaded over free area, Gent & Lindley (*Proc. Inst. Mech. Eng.* 173, 111, 1959) describe
bonded blocks by ``Ea = E (1 + 2 S²)``, for a disc. Where S is large the bulk gives way as well: then ``Ea = K I2(c)
/ I0(c)``, ``c = (a/h) sqrt(12 mu / K)`` (Kelly, *Earthquake-Resistant Design with Rubber*, 1997), to which the
rubber's own E is added. A quarter of half the disc is solved; slippery plates give E itself.
"""

from __future__ import annotations

import numpy as np
from scipy.special import iv

from palpate.core import FloatArray
from palpate.material import Material, NeoHooke
from palpate.verify.case import Row, compare
from palpate.verify.equilibrium import find_equilibrium, make_solid, reactions
from palpate.verify.mapped import Turn, even, join, revolve
from palpate.verify.rubber import BULK_RATIO

_RADIUS, _STRAIN = 10.0, 1e-3
_CELLS, _LAYERS = 8, 3
_SHAPES = (0.5, 1.0, 2.0, 4.0, 8.0)
_PAD, _PAD_SHAPES = 2000.0, (4.0, 8.0, 16.0)
"""K / mu, the default of the package, and the shape factors at which it tells."""
_LIKE, _EXACT, _SLIP = 4e-2, 2e-2, 2e-3


def apparent_modulus(shape: float, bulk_ratio: float, *, bonded: bool = True) -> float:
    """Stress over strain of a disc of a shape factor, over E; between slippery plates if it is not bonded."""
    half = _RADIUS / (4 * shape)

    def section(q: FloatArray) -> FloatArray:
        return np.column_stack([_RADIUS * q[:, 0], half * q[:, 1]])

    grid = join(revolve(section, (1 - even(_CELLS, 1.5)[::-1], even(_LAYERS)), Turn(2), solid=True))
    top = grid.near(2, half)
    fixed = np.stack([grid.near(0, 0.0), grid.near(1, 0.0), grid.near(2, 0.0) | top], axis=-1)
    fixed[top] |= bonded
    material = Material("rubber", NeoHooke(1 / 6), bulk_ratio=bulk_ratio)
    pressed = np.zeros_like(grid.nodes)
    pressed[top, 2] = -_STRAIN * half
    solid = make_solid(grid, material, fixed)
    force = -4 * reactions(solid, find_equilibrium(solid, pressed).state)[top, 2].sum()
    return float(force / (np.pi * _RADIUS**2 * _STRAIN * material.young_modulus))


def bonded_disc(*, bonded: bool = True) -> list[Row]:
    """Apparent moduli of bonded discs; with `bonded` false a control that must not pass."""
    shapes, pads = np.array(_SHAPES), np.array(_PAD_SHAPES)
    ours = [apparent_modulus(shape, BULK_RATIO, bonded=bonded) for shape in _SHAPES]
    pad = [apparent_modulus(shape, _PAD, bonded=bonded) for shape in _PAD_SHAPES]
    turn = 2 * pads * np.sqrt(12 / _PAD)
    bulk = (3 * _PAD + 1) / 9  # K over E
    return [
        compare("apparent modulus over E, incompressible", ours, 1 + 2 * shapes**2, _LIKE, _at(shapes)),
        compare("apparent modulus over E, K/mu = 2000", pad, 1 + bulk * iv(2, turn) / iv(0, turn), _EXACT, _at(pads)),
        compare("modulus between slippery plates over E", apparent_modulus(1.0, _PAD, bonded=False), 1.0, _SLIP),
    ]


def _at(shapes: FloatArray) -> list[str]:
    return [f"S = {shape:g}" for shape in shapes]
