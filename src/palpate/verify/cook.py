"""Cook's membrane at finite strain, nearly incompressible: a tapered panel, clamped and sheared.

Corners (0, 0), (48, 44), (48, 60), (0, 44) mm, plane strain, dead shear of 100 N on the right edge, neo-Hooke. It
reveals elements that lock: low-order ones without a remedy are 30 to 50 % too stiff.
"""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray
from palpate.material import Material, NeoHooke
from palpate.mechanics import OuterSurface
from palpate.verify.case import Row, below, compare
from palpate.verify.equilibrium import follow_load
from palpate.verify.mapped import Grid, even, join, map_block
from palpate.verify.read_reference import read_reference

SHEAR_MODULUS, BULK_MODULUS = 80.1938, 400942.0
"""Shear and bulk modulus, MPa: Young's modulus 240.565 MPa, Poisson's ratio 0.4999."""
FORCE = 100.0
"""Force on the free side, N."""
_WIDTH, _LEFT, _LOW, _HIGH = 48.0, 44.0, 44.0, 60.0
"""Corners of the membrane, mm."""
_STEPS = np.array([0.1, 0.3, 0.6, 1.0])


def make_panel(cells: int) -> Grid:
    """Mesh the panel by `cells` along each side, one through its thickness of 1 mm."""

    def place(q: FloatArray) -> FloatArray:
        up, through, along = q.T
        bottom, top = _LOW * along, _LEFT + (_HIGH - _LEFT) * along
        return np.column_stack([_WIDTH * along, bottom + up * (top - bottom), through])

    return join(map_block((even(cells), even(1), even(cells)), place))


def shear_panel(cells: int, bulk_ratio: float) -> FloatArray:
    """Displacement (3,) mm of the upper right corner."""
    grid = make_panel(cells)
    material = Material("Cook's", NeoHooke(SHEAR_MODULUS / 2), bulk_ratio=bulk_ratio)
    fixed = np.repeat(grid.near(0, 0.0)[:, None], 3, axis=1)
    fixed[:, 2] = True
    edge = grid.outer_cells(grid.near(0, _WIDTH))
    faces = OuterSurface(grid.nodes, grid.outer_faces(edge), edge).faces
    load = np.zeros(grid.nodes.shape)
    share = np.einsum("fq,qa->fa", faces.weight, faces.shape) / faces.weight.sum()
    np.add.at(load[:, 1], faces.nodes, FORCE * share)
    corner = grid.near(0, _WIDTH) & grid.near(1, _HIGH) & grid.near(2, 0.0)
    moved: FloatArray = follow_load(grid, material, fixed, load, _STEPS)[-1].u[corner][0]
    return moved


def cook_membrane() -> list[Row]:
    """Compare the corner displacement of each mesh with the reference code's Q2/P1 and the limit."""
    data = read_reference("cook_membrane").where(case="neo").between("elements_per_side_Q2P1", 2, 16)
    moved = np.array([shear_panel(int(n), BULK_MODULUS / SHEAR_MODULUS) for n in data["elements_per_side_Q2P1"]])
    at = [f"{n:g} x {n:g} cells" for n in data["elements_per_side_Q2P1"]]
    limit = read_reference("cook_membrane").where(case="Richardson")["uy_corner_48_60"]
    return [
        compare("ux of the corner, the same mesh, mm", moved[:, 0], data["ux_corner_48_60"], 1e-6, at),
        compare("uy of the corner, the same mesh, mm", moved[:, 1], data["uy_corner_48_60"], 1e-6, at),
        compare("uy of the corner, converged, mm", moved[-1:, 1], limit, 1e-2, at[-1:]),
    ]


def no_locking() -> list[Row]:
    """Compare a coarse mesh with one twice as fine, over K/mu: the error is constant without locking."""
    ratios = np.logspace(2, 6, 5)
    coarse = [shear_panel(4, ratio)[1] for ratio in ratios]
    fine = [shear_panel(8, ratio)[1] for ratio in ratios]
    error = np.abs(np.array(coarse) / np.array(fine) - 1)
    at = [f"K/µ = {ratio:.0e}" for ratio in ratios]
    return [
        compare("uy of the corner, 4 x 4 against 8 x 8 cells, mm", coarse, fine, 1e-2, at),
        below("spread of that error from K/µ = 1e3 to 1e6", float(np.ptp(error[1:])), 1e-3),
    ]
