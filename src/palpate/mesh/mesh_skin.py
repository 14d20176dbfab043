"""Mesh of a skin: the O-grid of the disc, mapped to the sphere and swept through the thickness."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from palpate.core import FloatArray, IntArray, PalpateError
from palpate.design import Skin
from palpate.mesh.disc import DiscGrid, grid_disc
from palpate.mesh.fill import mesh_filling
from palpate.mesh.hexahedron import INNER_FACE, OUTER_FACE
from palpate.mesh.mesh import Mesh
from palpate.mesh.spec import MeshSpec
from palpate.mesh.tube import CELLS, CORE, grid_tube

_MOST_CELLS_OF_A_CORE = 36
"""Maximum cells of a meridian for which half a turn needs only four cells (docs/design_notes/mesh.md)."""
_LOW = 0.75
"""Height over base radius below which a skin is low. By hand."""
_FARTHEST_POLE = 0.35
"""Maximum displacement of the pole, over the radius of the disc: at 0.5 the grid folds."""
_GRADING_HIGH, _GRADING_LOW = 0.2, -0.3
"""Share by which cells at the pole are smaller than the mean, and those at the rim larger.

The first is for a skin at least as high as its base radius, which bears the contact at its pole; the second for one
at most half as high, which bears it at its clamp. By hand.
"""
_FILLED_CELLS, _FILLED_CORE = 10, 3
"""Cells of a meridian of a filled skin, and its core, under which the block of the filling stands.
By hand."""
_CELLS, _MORE_CELLS, _THICK = 14.0, 40.0, 0.1
"""Cells per radian of a thin skin's meridian, additional cells over T/r, and T/r at which they begin.

See docs/design_notes/mesh.md.
"""


def mesh_skin(skin: Skin, spec: MeshSpec | None = None, pole: FloatArray | None = None) -> Mesh:
    """Mesh a skin with 27-node hexahedra, half (x >= 0, mirror plane x = 0) or whole; takes milliseconds.

    Parameters
    ----------
    skin
        The skin.
    spec
        Density, rim, half or whole.
    pole
        (2,) place of the grid's centre on the unit disc of the inner surface, on the mirror plane of a half skin; by
        default the apex, with twice as many cells in azimuth. For a tube, the place of the finest cells.
    """
    spec = spec or MeshSpec()
    if skin.hole:
        return _mesh_tube(skin, spec, pole)
    if spec.cells is None:
        spec = spec.model_copy(update={"cells": _FILLED_CELLS if spec.filled else default_cells(skin)})
    cells = spec.cells or 0
    if spec.filled:
        core = spec.core or min(_FILLED_CORE, cells - 1)
    else:
        core = spec.core or default_core(skin, cells, centred=pole is not None)
    grid = grid_disc(core, max(cells - core, 1), whole=spec.whole)
    place = _grade(skin, grid.points)
    if pole is not None:
        place = _move_pole(place, pole)
    on_mirror = np.empty(0, np.int64) if spec.whole else np.flatnonzero(np.abs(grid.points[:, 0]) < 1e-9)
    distance = np.hypot(*grid.points.T)
    flat = _Flat(place, grid.cells, np.flatnonzero(distance > 1 - 1e-9), on_mirror, int(np.argmin(distance)))
    made = _sweep(skin, spec, flat, pole)
    return _fill(made, grid) if spec.filled else made


def _mesh_tube(skin: Skin, spec: MeshSpec, pole: FloatArray | None) -> Mesh:
    """Mesh a skin that is open at both ends."""
    if spec.filled:
        raise PalpateError(
            f"{skin.name} is open at both ends, and its filling cannot be meshed.",
            "Leave out the gel.",
            code="filling-needs-apex",
        )
    spec = spec.model_copy(update={"cells": spec.cells or CELLS})
    grid = grid_tube(skin.hole, spec.cells or CELLS, spec.core or CORE, pole, whole=spec.whole)
    on_mirror = np.empty(0, np.int64) if spec.whole else np.flatnonzero(np.abs(grid.points[:, 0]) < 1e-9)
    middle = int(np.argmin(np.hypot(*(grid.points - (0.0 if pole is None else pole)).T)))
    return _sweep(skin, spec, _Flat(grid.points, grid.cells, grid.ends, on_mirror, middle), pole)


class _Flat(NamedTuple):
    """A grid on the unit disc: points (n, 2), cells (n_cells, 9), nodes on clamp and mirror, middle node."""

    points: FloatArray
    cells: IntArray
    clamped: IntArray
    mirror: IntArray
    middle: int


def _sweep(skin: Skin, spec: MeshSpec, flat: _Flat, pole: FloatArray | None) -> Mesh:
    """Map a grid to the skin and sweep it through the thickness."""
    steps, n = 2 * spec.layers + 1, len(flat.points)
    nodes = _lay(skin, flat.points, spec)
    layer_cells = [
        np.concatenate([flat.cells + (2 * layer + k) * n for k in range(3)], axis=1) for layer in range(spec.layers)
    ]
    through = (np.arange(steps) * n)[:, None]
    nodes[(through + flat.mirror).ravel(), 0] = 0.0
    return Mesh(
        skin=skin,
        spec=spec,
        nodes=nodes,
        cells=np.concatenate(layer_cells),
        inner_faces=layer_cells[0][:, INNER_FACE],
        outer_faces=layer_cells[-1][:, OUTER_FACE],
        inner_disc=np.tile(flat.points, (steps, 1)),
        base=(through + flat.clamped).ravel(),
        mirror=(through + flat.mirror).ravel(),
        pole=pole,
        pole_inner=flat.middle,
        pole_outer=flat.middle + (steps - 1) * n,
    )


def _fill(mesh: Mesh, grid: DiscGrid) -> Mesh:
    """Return the mesh with a filling."""
    n = len(mesh.nodes)
    fill = mesh_filling(grid, mesh.nodes[: len(grid.points)], n, whole=mesh.spec.whole)
    nodes = np.concatenate([mesh.nodes, fill.nodes])
    inside = np.arange(n, len(nodes))
    on_mirror = inside[:0] if mesh.spec.whole else inside[np.abs(fill.nodes[:, 0]) < 1e-9 * mesh.skin.base_radius]
    nodes[on_mirror, 0] = 0.0
    return replace(
        mesh,
        nodes=nodes,
        cells=np.concatenate([fill.cells, mesh.cells]),
        base=np.concatenate([mesh.base, fill.base]),
        mirror=np.concatenate([mesh.mirror, on_mirror]),
        filling=len(fill.cells),
    )


def centre_mesh(mesh: Mesh, touched: FloatArray) -> Mesh:
    """Mesh the same skin with its pole at a point (3,) mm of the outer surface, unless it has one already.

    A mesh with `centred` false in its spec is unchanged. About the first-contact point a press is nearly
    axisymmetric, so few cells are needed in azimuth.
    """
    if not mesh.spec.centred or mesh.pole is not None:
        return mesh
    pole = mesh.skin.disc(touched[None])[0]
    if not mesh.spec.whole:
        pole[0] = 0.0
    if mesh.skin.hole:
        return mesh_skin(mesh.skin, mesh.spec, pole)
    pole *= min(1.0, _FARTHEST_POLE / max(float(np.hypot(*pole)), _FARTHEST_POLE))
    return mesh_skin(mesh.skin, mesh.spec, pole)


def reshape_mesh(mesh: Mesh, skin: Skin) -> Mesh:
    """Return the mesh of another skin, with equal places on the unit disc and through the thickness."""
    layers = 2 * mesh.spec.layers + 1
    nodes = _lay(skin, mesh.inner_disc[: len(mesh.nodes) // layers], mesh.spec)
    nodes[mesh.mirror, 0] = 0.0
    return replace(mesh, skin=skin, nodes=nodes)


def _lay(skin: Skin, place: FloatArray, spec: MeshSpec) -> FloatArray:
    """Return nodes (n, 3) mm at places of the unit disc, layer by layer."""
    layers = np.linspace(0.0, 1.0, 2 * spec.layers + 1)
    return np.concatenate([skin.point(place, layer, spec.rim) for layer in layers])


def default_core(skin: Skin, cells: int, *, centred: bool) -> int:
    """Return the core for a number of cells from pole to rim; doubled if the pole is not at the contact.

    It is doubled for a low skin too: the patch is so close to the clamp that the press is not axisymmetric about the
    pole.
    """
    low = skin.height < _LOW * skin.base_radius
    return (1 + (cells - 1) // _MOST_CELLS_OF_A_CORE) * (1 if centred and not low else 2)


def default_cells(skin: Skin) -> int:
    """Return the cells from pole to rim that keep a press within about 1 % of a mesh twice as fine.

    The cell is a fixed angle, since the contact patch spans some tenths of a radian. Thinner skins need no smaller
    cells; thicker ones do, because they shear at the edge of the patch.
    """
    thick = max(skin.thickness / skin.radius - _THICK, 0.0)
    return int(np.clip(round(skin.inner_slope * (_CELLS + _MORE_CELLS * thick)), 22, 48))


def _move_pole(disc: FloatArray, pole: FloatArray) -> FloatArray:
    """Move points (n, 2) of the unit disc so that its centre is at `pole` (2,); the circle is unchanged."""
    return disc + (1 - (disc**2).sum(axis=1))[:, None] * pole


def _grade(skin: Skin, disc: FloatArray) -> FloatArray:
    """Concentrate the points (n, 2) of the unit disc where the contact is; centre and rim are unchanged."""
    height = skin.height / skin.base_radius
    share = float(np.interp(height, [0.5, 1.0], [_GRADING_LOW, _GRADING_HIGH]))
    return disc * (1 - share + share * np.hypot(disc[:, 0], disc[:, 1])[:, None])
