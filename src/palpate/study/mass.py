"""Mass, centre and inertia of a skin, by Gauss quadrature over the cells of a fine mesh."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from palpate.core import FloatArray
from palpate.design import Skin, Symmetry
from palpate.mesh import MeshSpec, gauss_points, mesh_skin, shape_hexahedron

_GAUSS = (5, 5, 5)
"""Gauss points: exact for second moments of cells with parabolic edges (degree 9 in each coordinate)."""
_CELLS, _CORE = 32, 8
"""Cells of the mesh: the error of a hemispherical shell's mass is 4e-7."""
_ROUNDING = 1e-12
"""Share of the largest component below which one is zero."""


class MassProperties(NamedTuple):
    """Mass properties of a rigid body.

    Attributes
    ----------
    mass_kg
        Mass.
    centre_mm
        (3,) centre of mass in the frame of the skin.
    inertia
        (3, 3) kg m² about the centre, axes of the skin.
    """

    mass_kg: float
    centre_mm: FloatArray
    inertia: FloatArray


def compute_mass_properties(skin: Skin, density: float, *, filled: bool = False) -> MassProperties:
    """Compute the mass properties of a skin of one density (kg/m³), which a gel inside shares.

    With the second moments ``S = ∫ ρ r rᵀ dV`` about the centre the inertia is ``tr(S) 1 - S``.
    """
    whole = skin.symmetry is not Symmetry.REVOLVED
    mesh = mesh_skin(skin, MeshSpec(cells=_CELLS, core=_CORE, whole=whole, filled=filled))
    local, weights = gauss_points(_GAUSS)
    value, gradient = shape_hexahedron(local)
    corners = mesh.nodes[mesh.cells]
    points = np.einsum("gn,cni->cgi", value, corners).reshape(-1, 3)
    jacobian = np.einsum("gnk,cni->cgik", gradient, corners)
    volumes = (np.abs(np.linalg.det(jacobian)) * weights).ravel()
    if not whole:
        points = np.concatenate([points, points * [-1.0, 1.0, 1.0]])
        volumes = np.concatenate([volumes, volumes])
    mass = density * float(volumes.sum()) * 1e-9
    centre = _whole(volumes @ points / volumes.sum())
    arms = points - centre
    second = density * np.einsum("p,pi,pj->ij", volumes, arms, arms) * 1e-15
    return MassProperties(mass, centre, _whole(np.trace(second) * np.eye(3) - second))


def _whole(values: FloatArray) -> FloatArray:
    """Set values to zero that are only rounding errors."""
    return np.where(np.abs(values) < _ROUNDING * np.abs(values).max(), 0.0, values)
