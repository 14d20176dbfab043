"""How much a press depends on its mesh: the paper's Fig. 9, and what a user needs more, force and markers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.fea.press import Press
from palpate.fea.solve_press import solve_press
from palpate.fea.spec import ObstacleSpec
from palpate.material import Material
from palpate.mesh import Mesh, MeshSpec, mesh_skin

CELLS = (8, 11, 16, 22, 32)
"""Cells from pole to rim: each mesh has about twice the elements of the one before."""


@dataclass(frozen=True)
class MeshResult:
    """What one mesh says of a press at the deepest increment that every mesh reached, against the finest mesh.

    Attributes
    ----------
    cells
        Cells from pole to rim.
    elements, unknowns
        Of the modelled part.
    depth
        mm, of the increment compared.
    peak_stress
        MPa, greatest von Mises stress.
    force
        N along the dome's axis.
    stress_error, force_error
        Deviation over the value of the finest mesh.
    marker_error
        Root mean square distance of the points from those of the finest mesh, over the depth.
    worst_marker_error
        The greatest such distance, over the depth.
    cpu_s
        Cost of the press.
    """

    cells: int
    elements: int
    unknowns: int
    depth: float
    peak_stress: float
    force: float
    stress_error: float
    force_error: float
    marker_error: float
    worst_marker_error: float
    cpu_s: float


def study_convergence(
    mesh: Mesh,
    material: Material,
    obstacle: ObstacleSpec,
    points: FloatArray,
    cells: Sequence[int] = CELLS,
    on_press: Callable[[int, Press], None] = lambda cells, press: None,
) -> tuple[MeshResult, ...]:
    """Press one dome on finer and finer meshes.

    Parameters
    ----------
    mesh, material, obstacle
        As in `palpate.fea.solve_press`; the mesh gives dome, layers, rim, half or whole.
    points
        (m, 3) mm of the undeformed inner surface, followed on every mesh.
    cells
        Cells from pole to rim, at least two different numbers.
    on_press
        Called with every press when it is solved.

    Returns
    -------
    tuple[MeshResult, ...]
        One a mesh, from the coarsest to the finest, whose errors are zero.

    Raises
    ------
    PalpateError
        If fewer than two meshes are given, or they share no increment but rest.
    """
    counts = sorted(set(cells))
    if len(counts) < 2:
        raise PalpateError(
            f"A convergence study needs two meshes, and was given {len(counts)}.",
            "Give several numbers of cells.",
            code="convergence-few-meshes",
        )
    presses = []
    for count in counts:
        spec = mesh.spec.model_copy(update={"cells": MeshSpec(cells=count).cells})
        presses.append(solve_press(mesh_skin(mesh.skin, spec), material, obstacle))
        on_press(count, presses[-1])
    return tuple(_compare(presses, points, _deepest_shared(presses)))


def _deepest_shared(presses: Sequence[Press]) -> float:
    shared: set[float] = set.intersection(*({round(float(depth), 6) for depth in press.depth} for press in presses))
    if max(shared) == 0:
        raise PalpateError(
            "The presses share no depth but rest.",
            "Choose a finer step, or more cells.",
            code="presses-share-no-depth",
        )
    return max(shared)


def _compare(presses: Sequence[Press], points: FloatArray, depth: float) -> Iterable[MeshResult]:
    finest, increments = presses[-1], list(_images(presses, depth))
    expected = finest.positions(points)[increments[-1]]
    for press, increment in zip(presses, increments, strict=True):
        distance = np.linalg.norm(press.positions(points)[increment] - expected, axis=1) / depth
        yield MeshResult(
            cells=press.mesh.spec.cells or 0,
            elements=len(press.mesh.cells),
            unknowns=press.unknowns,
            depth=depth,
            peak_stress=float(press.peak_stress[increment]),
            force=float(press.force[increment, 2]),
            stress_error=float(press.peak_stress[increment] / finest.peak_stress[increments[-1]] - 1),
            force_error=float(press.force[increment, 2] / finest.force[increments[-1], 2] - 1),
            marker_error=float(np.sqrt((distance**2).mean())),
            worst_marker_error=float(distance.max()),
            cpu_s=press.cpu_s,
        )


def _images(presses: Sequence[Press], depth: float) -> Iterator[int]:
    for press in presses:
        yield int(np.abs(press.depth - depth).argmin())
