"""A solid body: cells, material and degrees of freedom, with energy, residual and tangent."""

from __future__ import annotations

from abc import ABC, abstractmethod
from copy import copy
from dataclasses import dataclass
from typing import final

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray, PalpateError
from palpate.material import Material
from palpate.mechanics.element import (
    DOFS,
    PRESSURES,
    Cells,
    Condensed,
    Response,
    System,
    add_residual,
    add_tangent,
    deform_cells,
    recover_pressure,
)
from palpate.mechanics.linear import Pattern
from palpate.mesh import gauss_points, shape_hexahedron

GAUSS = (3, 3, 3)
"""Gauss points of a cell: exact for the products of shape functions of an undistorted cell."""


@dataclass(frozen=True)
class State:
    """Displacement and pressure of a solid.

    Attributes
    ----------
    u
        (n, 3) mm nodal displacement.
    p
        (n_cells, 4) MPa pressure coefficients of 1, xi, eta, zeta in each cell (positive in tension).
    """

    u: FloatArray
    p: FloatArray

    def moved(self, du: FloatArray, dp: FloatArray, factor: float = 1.0) -> State:
        """Return the state moved by increments (n, 3) mm and (n_cells, 4) MPa."""
        return State(self.u + factor * du, self.p + factor * dp)


class Body(ABC):
    """Interface of a body for Newton's method: unknowns, couplings, and energy with its derivatives.

    Attributes
    ----------
    nodes
        (n, 3) mm, undeformed.
    free
        (n_free,) numbers of the free ones of the 3 n displacement components.
    pattern
        Sparse upper triangle of their couplings.
    place
        (n_cells, 3321) index into it for every entry of a cell's upper triangle; -1 for entries that are left out.
    nodal_volume
        (n,) mm³ of each node.
    shear_modulus
        MPa, the scale of the tangent.
    """

    nodes: FloatArray
    free: IntArray
    pattern: Pattern
    place: IntArray
    nodal_volume: FloatArray
    shear_modulus: float

    @abstractmethod
    def rest(self) -> State:
        """Return the state at rest."""

    @abstractmethod
    def add_residual(self, state: State, residual: FloatArray) -> float:
        """Add the residual (3 n,) N; return the stored energy, mJ, infinite if a cell is inverted."""

    @abstractmethod
    def add_tangent(self, state: State, data: FloatArray) -> None:
        """Add the tangent at the state of the last `add_residual` to the values (nnz,) of the matrix."""

    @abstractmethod
    def recover_pressure(self, du: FloatArray) -> FloatArray:
        """Return the pressure increments (n_cells, 4) MPa of `du` (n, 3) mm since the last `add_residual`."""

    def assemble(self, state: State, system: System) -> float:
        """Add tangent and residual to `system`; return the stored energy, mJ, infinite if a cell is inverted."""
        energy = self.add_residual(state, system.residual)
        if np.isfinite(energy):
            self.add_tangent(state, system.data)
        return energy


@final
class Solid(Body):
    """A body of 27-node hexahedra with prescribed degrees of freedom.

    Parameters
    ----------
    nodes
        (n, 3) mm.
    cells
        (n_cells, 27) node numbers.
    material
        The material.
    fixed
        (n, 3) bool, True if the displacement is prescribed (its value is in the state).
    filling
        Number of cells, from the first, that consist of the material's gel.
    """

    def __init__(
        self, nodes: FloatArray, cells: IntArray, material: Material, fixed: BoolArray, filling: int = 0
    ) -> None:
        self.nodes, self.material, self.fixed, self.filling = nodes, material, fixed, filling
        cells = np.ascontiguousarray(cells, dtype=np.int64)
        self.shape = shape_hexahedron(gauss_points(GAUSS)[0])[0]
        self.equation = np.full(nodes.size, -1, np.int64)
        self.free = np.flatnonzero(~fixed.ravel())
        self.equation[self.free] = np.arange(len(self.free))
        self.pattern, place = _find_pattern(cells, self.equation, len(self.free))
        self.cells = Cells(nodes=cells, basis=_pressure_basis(), place=place, **_tables(nodes, cells))
        self.place = place
        self.nodal_volume = np.zeros(len(nodes))
        np.add.at(self.nodal_volume, cells, np.einsum("eg,ga->ea", self.cells.weight, self.shape**2))
        self.shear_modulus = material.law.shear_modulus
        self.bulk = self._bulk()
        self._F = np.empty((*self.cells.weight.shape, 3, 3))
        self._condensed = Condensed(np.empty((len(cells), PRESSURES, DOFS)), np.empty((len(cells), PRESSURES)))

    @property
    def unknowns(self) -> int:
        """Number of free displacement components."""
        return len(self.free)

    def rest(self) -> State:
        return State(np.zeros_like(self.nodes), np.zeros((len(self.cells.nodes), PRESSURES)))

    def add_residual(self, state: State, residual: FloatArray) -> float:
        response = self.respond(state)
        if response is None:
            return np.inf
        self._response = response
        return add_residual(self.cells, response, self.bulk, state.p, residual, self._condensed)

    def add_tangent(self, state: State, data: FloatArray) -> None:
        add_tangent(self.cells, self._response, self.bulk, state.p, self._condensed.coupling, data)

    def remade(self, nodes: FloatArray, material: Material) -> Solid:
        """Return the same cells and unknowns with other nodes (n, 3) mm and another material."""
        other = copy(self)
        other._F = np.empty_like(self._F)
        other._condensed = Condensed(*(np.empty_like(part) for part in self._condensed))
        other.nodes, other.material = nodes, material
        other.shear_modulus = material.law.shear_modulus
        other.bulk = other._bulk()
        other.cells = Cells(
            nodes=self.cells.nodes, basis=self.cells.basis, place=self.place, **_tables(nodes, self.cells.nodes)
        )
        return other

    def respond(self, state: State) -> Response | None:
        """Return the response of the law at the Gauss points; `None` if a cell is inverted."""
        if not deform_cells(self.cells, state.u, self._F):
            return None
        energy, tau, c = self._evaluate(self._F.reshape(-1, 3, 3))
        shape = self.cells.weight.shape
        return Response(self._F, energy.reshape(shape), tau.reshape(*shape, 6), c.reshape(*shape, 6, 6))

    def _evaluate(self, F: FloatArray) -> tuple[FloatArray, ...]:
        """Return energy, stress and tangent of the laws at (n, 3, 3) deformation gradients."""
        inside = self.filling * self.cells.weight.shape[1]
        if not inside:
            found: tuple[FloatArray, ...] = self.material.evaluate(F)
        else:
            parts = self._gel.evaluate(F[:inside]), self.material.evaluate(F[inside:])
            found = tuple(np.concatenate(pair) for pair in zip(*parts, strict=True))
        return tuple(np.require(each, np.float64, ("C", "W")) for each in found)  # a law may be another's

    @property
    def _gel(self) -> Material:
        if self.material.gel is None:
            raise PalpateError(
                f"The mesh is filled, but the material {self.material.name} has no gel.",
                "Give the material a gel, or mesh the skin without filling.",
                code="gel-missing",
            )
        return self.material.gel

    def _bulk(self) -> FloatArray:
        """Return the bulk modulus (n_cells,) MPa."""
        bulk = np.full(len(self.cells.nodes), self.material.bulk_modulus)
        if self.filling:
            bulk[: self.filling] = self._gel.bulk_modulus
        return bulk

    def recover_pressure(self, du: FloatArray) -> FloatArray:
        dp = np.empty((len(self.cells.nodes), PRESSURES))
        recover_pressure(self.cells, self.bulk, self._condensed, du, dp)
        return dp


def _pressure_basis() -> FloatArray:
    """Return the basis (n_points, 4) of the pressure at the Gauss points: 1, xi, eta, zeta."""
    points, _ = gauss_points(GAUSS)
    return np.column_stack([np.ones(len(points)), points])


def _tables(nodes: FloatArray, cells: IntArray) -> dict[str, FloatArray]:
    """Return the tables of `Cells` that depend on the nodes (n, 3) mm."""
    points, weights = gauss_points(GAUSS)
    _, local = shape_hexahedron(points)
    jacobian = np.einsum("eai,gaj->egij", nodes[cells], local, optimize=True)
    weight = np.linalg.det(jacobian) * weights
    basis = _pressure_basis()
    mass = np.einsum("eg,gk,gm->ekm", weight, basis, basis)
    gradient = np.einsum("gaj,egji->egai", local, np.linalg.inv(jacobian), optimize=True)
    return {
        "gradient": np.ascontiguousarray(gradient),
        "weight": np.ascontiguousarray(weight),
        "inverse_mass": np.linalg.inv(mass),
    }


def _find_pattern(cells: IntArray, equation: IntArray, size: int) -> tuple[Pattern, IntArray]:
    """Return the sparse upper triangle of all cells, and the index into it of every entry of a cell's."""
    i, j = np.triu_indices(DOFS)
    if not size:
        return Pattern(np.zeros(1, np.int64), np.zeros(0, np.int64)), np.full((len(cells), len(i)), -1, np.int32)
    dofs = equation[(3 * cells[:, :, None] + np.arange(3)).reshape(len(cells), DOFS)]
    row, column = np.minimum(dofs[:, i], dofs[:, j]), np.maximum(dofs[:, i], dofs[:, j])
    key = np.where(row >= 0, row * size + column, -1)
    unique, inverse = np.unique(key, return_inverse=True)
    place = inverse.reshape(key.shape)
    if len(unique) and unique[0] < 0:
        unique, place = unique[1:], place - 1
    start = np.searchsorted(unique // max(size, 1), np.arange(size + 1))
    return Pattern(start=start, column=unique % max(size, 1)), np.ascontiguousarray(place, dtype=np.int32)
