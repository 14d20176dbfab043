"""Mesh convergence of a press: stress as in the paper's Fig. 9, force and marker positions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.fea.press import Press
from palpate.fea.solve_press import solve_press
from palpate.fea.spec import CELLS, ObstacleSpec
from palpate.material import Material
from palpate.mesh import Mesh, MeshSpec, mesh_skin


@dataclass(frozen=True)
class MeshResult:
    """Result of one mesh at the maximum depth that all meshes share, compared with the finest mesh.

    Attributes
    ----------
    cells, elements, unknowns
        Cells from pole to rim, and size of the modelled part.
    depth, peak_stress, force
        Depth of the compared increment (mm), maximum von Mises stress (MPa), force along the skin's axis (N).
    stress_error, force_error
        Relative deviation from the finest mesh.
    marker_error, worst_marker_error
        Root mean square and maximum distance of the points from those of the finest mesh, over the depth.
    cpu_s
        CPU time of the press.
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
    """Press one skin on successively finer meshes.

    Parameters
    ----------
    mesh, material, obstacle
        As in `palpate.fea.solve_press`; the mesh gives skin, layers, rim, half or whole.
    points
        (m, 3) mm on the undeformed inner surface, followed on every mesh.
    cells
        Cells from pole to rim, at least two different numbers.
    on_press
        Called with every press when it is solved.

    Returns
    -------
    tuple[MeshResult, ...]
        One for each mesh, from the coarsest to the finest, whose errors are zero.

    Raises
    ------
    PalpateError
        If fewer than two meshes are given, or they share no increment except rest.
    """
    counts = sorted(set(cells))
    if len(counts) < 2:
        raise PalpateError(
            f"A convergence study needs at least two meshes; got {len(counts)}.",
            "Give two or more different numbers of cells.",
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
            "The presses share no depth except rest.",
            "Choose a smaller depth step, or more cells.",
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
