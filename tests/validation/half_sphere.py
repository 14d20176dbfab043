"""A solid half ball under a frictionless plate, by an axisymmetric program of its own: six-node triangles.

It shares nothing with the bricks of the package: total Lagrangian, truly incompressible neo-Hookean of the energy
``C10 (I1 - 3) - p (J - 1)`` with pressures at the corners (Taylor & Hood 1973), on Delaunay's triangles of points
that lie on circles about the pole, as dense as the contact needs. In a meridian plane the deformation gradient has
five components, ``F = (1 + u_r,R; u_r,Z; u_z,R; 1 + u_z,Z; 1 + u_r/R)``, and ``J = (F1 F4 - F2 F3) F5``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import splu
from scipy.spatial import Delaunay

from palpate.core import BoolArray, FloatArray, IntArray, PalpateError

_STIFF = 3e4
"""Penalty times the radius over C10: the plate comes in by less than a thousandth of the depth."""
_GROWTH = 0.1
"""Growth of the triangles beyond the contact."""
_NEWTON, _TOLERANCE = 40, 1e-9
_A, _B = 0.445948490915965, 0.091576213509771
_CORNERS = np.array([[_A, _A], [_A, 1 - 2 * _A], [1 - 2 * _A, _A], [_B, _B], [_B, 1 - 2 * _B], [1 - 2 * _B, _B]])
_WEIGHTS = 0.5 * np.repeat([0.223381589678011, 0.109951743655322], 3)
"""Six points of a triangle, exact to the fourth degree (Dunavant 1985)."""


class Pressed(NamedTuple):
    """A half ball at one depth: force (N), stored energy (mJ) and the ways (n,) mm that points of the axis sank."""

    force: float
    energy: float
    sunk: FloatArray


@dataclass(frozen=True)
class _Triangles:
    """Mesh of a quarter disc of radius 1 in the plane of r and z.

    Attributes
    ----------
    nodes
        (n, 2), the corners first.
    corners
        How many corners.
    cells
        (k, 6) node numbers: corners, then the middles of the sides 01, 12, 20.
    rim
        (m, 3) node numbers of sides on the arc: ends, middle.
    """

    nodes: FloatArray
    corners: int
    cells: IntArray
    rim: IntArray


def press_half_ball(
    depths: Sequence[float], c10: float, axis: Sequence[float] = (), *, bonded: bool = True, cell: float = 0.03
) -> list[Pressed]:
    """Press a half ball of radius 1 mm on a rigid base.

    Parameters
    ----------
    depths
        Rising, mm; steps of at most 0.01 mm lead to each.
    c10
        MPa.
    axis
        Heights over the base of points of the axis whose sinking is asked for, mm.
    bonded
        Whether it is bonded to the base; or slides on it, as half of a ball between two plates does.
    cell
        Size of the triangles under the plate, mm.

    Raises
    ------
    PalpateError
        If a step does not converge.
    """
    mesh = _make_triangles(cell, float(np.sqrt(max(depths))))
    problem = _Problem(mesh, c10, _held(mesh.nodes, bonded=bonded))
    x, before, found = problem.rest(), 0.0, []
    on_axis = np.flatnonzero(mesh.nodes[:, 0] < 1e-12)
    on_axis = on_axis[np.argsort(mesh.nodes[on_axis, 1])]
    for depth in depths:
        for step in np.linspace(before, depth, int(np.ceil((depth - before) / 0.01)) + 1)[1:]:
            x = problem.solve(x, 1.0 - float(step))
        before = depth
        force, energy = problem.measure(x, 1.0 - depth)
        sunk = -np.interp(axis, mesh.nodes[on_axis, 1], x[2 * on_axis + 1])
        found.append(Pressed(force, energy, sunk))
    return found


def _make_triangles(cell: float, fine: float) -> _Triangles:
    """Triangles of one size (mm) to this distance from the pole (mm), and growing beyond."""

    def size(d: float) -> float:
        return max(cell, cell + _GROWTH * (d - fine))

    far = [0.0]
    while far[-1] < np.sqrt(2):
        far.append(far[-1] + size(far[-1]))
    points = [np.zeros((1, 2))]
    for d in np.sqrt(2) / far[-1] * np.array(far):
        # from the axis, or the base, around to the arc, whose points are at the chord d
        first = 0.0 if d <= 1 else np.arccos(1 / d)
        last = np.arccos(min(d / 2, 1.0))
        count = int(np.ceil((last - first) * d / size(d)))
        angle = np.linspace(first, last, count + 1)
        points.append(np.column_stack([d * np.sin(angle), 1 - d * np.cos(angle)]))
    corner = np.unique(np.round(np.concatenate(points), 13), axis=0)
    cells = Delaunay(corner).simplices
    arms = corner[cells[:, 1:]] - corner[cells[:, :1]]
    turned = arms[:, 0, 0] * arms[:, 1, 1] - arms[:, 0, 1] * arms[:, 1, 0]
    cells = np.where(turned[:, None] < 0, cells[:, [0, 2, 1]], cells)[np.abs(turned) > 1e-9]
    sides = np.sort(np.concatenate([cells[:, [0, 1]], cells[:, [1, 2]], cells[:, [2, 0]]]), axis=1)
    side, number, count_of = np.unique(sides, axis=0, return_inverse=True, return_counts=True)
    middle = corner[side].mean(axis=1)
    arc = (count_of == 1) & (np.abs(np.linalg.norm(corner[side], axis=2) - 1) < 1e-9).all(axis=1)
    middle[arc] /= np.linalg.norm(middle[arc], axis=1)[:, None]
    middles = len(corner) + number.reshape(3, -1).T
    rim = np.column_stack([side[arc], len(corner) + np.flatnonzero(arc)])
    return _Triangles(np.concatenate([corner, middle]), len(corner), np.column_stack([cells, middles]), rim)


def _held(nodes: FloatArray, *, bonded: bool) -> BoolArray:
    """Displacements (2 n,) that are held: the axis across, the base along it, and across where it is bonded."""
    base = np.abs(nodes[:, 1]) < 1e-9
    return np.column_stack([(nodes[:, 0] < 1e-9) | (base & bonded), base]).reshape(-1)


class _Problem:
    """Equilibrium of displacements (2 n,) and pressures at the corners, one vector."""

    def __init__(self, mesh: _Triangles, c10: float, held: BoolArray) -> None:
        self._mesh, self._c10 = mesh, c10
        count = len(held)
        self._free = np.flatnonzero(np.concatenate([~held, np.ones(mesh.corners, bool)]))
        self._total = count + mesh.corners
        shape, slope = _shapes(_CORNERS)
        place = mesh.nodes[mesh.cells]
        jacobian = np.einsum("gai,eaj->egij", slope, place)
        local = np.einsum("egij,gaj->egai", np.linalg.inv(jacobian), slope)
        r = np.einsum("ga,ea->eg", shape, place[..., 0])
        self._volume = 2 * np.pi * r * np.linalg.det(jacobian) * _WEIGHTS
        self._by_u = np.zeros((*r.shape, 5, 12))
        self._by_u[..., 0, 0::2], self._by_u[..., 1, 0::2] = local[..., 0], local[..., 1]
        self._by_u[..., 2, 1::2], self._by_u[..., 3, 1::2] = local[..., 0], local[..., 1]
        self._by_u[..., 4, 0::2] = shape / r[..., None]
        self._pressure = np.column_stack([1 - _CORNERS.sum(axis=1), _CORNERS])
        moves = (2 * mesh.cells[..., None] + np.arange(2)).reshape(len(mesh.cells), 12)
        self._numbers = np.column_stack([moves, count + mesh.cells[:, :3]])
        node, weight = np.polynomial.legendre.leggauss(5)
        self._line = np.column_stack([0.5 * node * (node - 1), 0.5 * node * (node + 1), 1 - node**2])
        along = np.column_stack([node - 0.5, node + 0.5, -2 * node])
        rim = mesh.nodes[mesh.rim]
        length = np.linalg.norm(np.einsum("ga,eai->egi", along, rim), axis=2)
        self._area = 2 * np.pi * np.einsum("ga,ea->eg", self._line, rim[..., 0]) * length * weight
        self._height = np.einsum("ga,ea->eg", self._line, rim[..., 1])

    def rest(self) -> FloatArray:
        """The vector at rest, where the pressure balances the law's stress."""
        return np.concatenate(
            [np.zeros(self._total - self._mesh.corners), np.full(self._mesh.corners, 2 * self._c10)]
        )

    def solve(self, x: FloatArray, plate: float) -> FloatArray:
        """Newton's iteration from a vector to the equilibrium under a plate at this height."""
        scale = self._c10
        for _ in range(_NEWTON):
            residual, tangent = self._assemble(x, plate)
            free = residual[self._free]
            if np.abs(free).max() < _TOLERANCE * scale:
                return x
            x = x.copy()
            x[self._free] -= splu(tangent[self._free][:, self._free]).solve(free)
        raise PalpateError(
            f"The half ball was not solved at {1 - plate:.3g} mm.",
            "Take smaller triangles.",
            code="half-ball-not-solved",
        )

    def measure(self, x: FloatArray, plate: float) -> tuple[float, float]:
        """Force (N) on the plate and stored energy (mJ)."""
        F = self._gradient(x)
        stored = self._c10 * ((F**2).sum(axis=2) - 3)
        return float((self._push(x, plate) * self._area).sum()), float((stored * self._volume).sum())

    def _gradient(self, x: FloatArray) -> FloatArray:
        F = np.einsum("egfi,ei->egf", self._by_u, x[self._numbers[:, :12]])
        return np.asarray(F + np.array([1.0, 0.0, 0.0, 1.0, 1.0]))

    def _push(self, x: FloatArray, plate: float) -> FloatArray:
        height = self._height + np.einsum("ga,ea->eg", self._line, x[2 * self._mesh.rim + 1])
        return np.asarray(_STIFF * self._c10 * np.maximum(height - plate, 0.0))

    def _assemble(self, x: FloatArray, plate: float) -> tuple[FloatArray, csc_matrix]:
        F = self._gradient(x)
        p = np.einsum("ga,ea->eg", self._pressure, x[self._numbers[:, 12:]])
        area = F[..., 0] * F[..., 3] - F[..., 1] * F[..., 2]
        cofactor = np.stack([F[..., 3], -F[..., 2], -F[..., 1], F[..., 0]], axis=-1)
        by_F = np.concatenate([cofactor * F[..., 4:], area[..., None]], axis=-1)
        twice = np.zeros((*p.shape, 5, 5))
        for i, j, sign in ((0, 3, 1.0), (1, 2, -1.0)):
            twice[..., i, j] = twice[..., j, i] = sign * F[..., 4]
        twice[..., :4, 4] = twice[..., 4, :4] = cofactor
        stress = 2 * self._c10 * F - p[..., None] * by_F
        stiffness = 2 * self._c10 * np.eye(5) - p[..., None, None] * twice
        B, dv = self._by_u, self._volume
        own = np.zeros((len(B), 15))
        own[:, :12] = np.einsum("egfi,egf,eg->ei", B, stress, dv)
        own[:, 12:] = -np.einsum("ga,eg,eg->ea", self._pressure, area * F[..., 4] - 1, dv)
        block = np.zeros((len(B), 15, 15))
        block[:, :12, :12] = np.einsum("egfi,egfh,eghj,eg->eij", B, stiffness, B, dv, optimize=True)
        block[:, :12, 12:] = -np.einsum("egfi,egf,ga,eg->eia", B, by_F, self._pressure, dv, optimize=True)
        block[:, 12:, :12] = block[:, :12, 12:].transpose(0, 2, 1)
        return self._sum(own, block, self._push(x, plate))

    def _sum(self, own: FloatArray, block: FloatArray, push: FloatArray) -> tuple[FloatArray, csc_matrix]:
        """Residual and tangent of triangles and of the plate's push."""
        rim = 2 * self._mesh.rim + 1
        residual = np.bincount(self._numbers.ravel(), own.ravel(), self._total)
        residual += np.bincount(
            rim.ravel(), np.einsum("ga,eg->ea", self._line, push * self._area).ravel(), self._total
        )
        stiff = _STIFF * self._c10 * (push > 0) * self._area
        pressed = np.einsum("ga,gb,eg->eab", self._line, self._line, stiff)
        rows = [np.repeat(self._numbers, 15, axis=1).ravel(), np.repeat(rim, 3, axis=1).ravel()]
        columns = [np.tile(self._numbers, 15).ravel(), np.tile(rim, 3).ravel()]
        values = np.concatenate([block.ravel(), pressed.ravel()])
        shape = (self._total, self._total)
        return np.asarray(residual, float), csc_matrix(
            (values, (np.concatenate(rows), np.concatenate(columns))), shape
        )


def _shapes(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Values (g, 6) and slopes (g, 6, 2) of the six shape functions at points (g, 2) of the unit triangle."""
    a, b = points.T
    c = 1 - a - b
    values = np.stack([c * (2 * c - 1), a * (2 * a - 1), b * (2 * b - 1), 4 * c * a, 4 * a * b, 4 * b * c], axis=1)
    zero = 0 * a
    by_a = np.stack([1 - 4 * c, 4 * a - 1, zero, 4 * (c - a), 4 * b, -4 * b], axis=1)
    by_b = np.stack([1 - 4 * c, zero, 4 * b - 1, -4 * a, 4 * a, 4 * (c - b)], axis=1)
    return values, np.stack([by_a, by_b], axis=-1)
