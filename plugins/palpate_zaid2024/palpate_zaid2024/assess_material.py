"""Claims that need no grid: C1, the law of Table 2, and C2, the mesh."""

from __future__ import annotations

import csv
from dataclasses import fields
from pathlib import Path

import numpy as np

from palpate.core import PalpateError
from palpate.fea import MeshResult
from palpate.material import Mode, get_material, trace_curve
from palpate_zaid2024.claim import ClaimFinding, Verdict

TABLE_2 = "yeoh:0.0141156,0.0001106,0.0000048"
"""The Yeoh constants of the paper's Table 2 (MPa)."""
MEASURED_MPA = {5.0: 0.25, 0.5: -0.10}
"""Measured nominal stress by stretch, as stated in the paper (MPa)."""
WITHIN = 0.05
"""Relative difference below which two stresses count as equal."""
PRINTED_ELEMENTS = 2438
HALVES = 2
"""A half model has half the elements of the dome."""
CONVERGENCE = "convergence*.csv"
"""Files of `palpate design convergence --out`; a contact law may be appended to the name."""


def assess_law() -> ClaimFinding:
    """Assess C1: compare the law of Table 2 with the paper's two measured values."""
    stretch = np.array(list(MEASURED_MPA))
    found = trace_curve(get_material(TABLE_2), Mode.UNIAXIAL, stretch).nominal
    errors = [float(value / expected - 1) for value, expected in zip(found, MEASURED_MPA.values(), strict=True)]
    figures = (
        f"stretch 5: {found[0]:.4f} MPa ({100 * errors[0]:+.1f} %); "
        f"half height: {-found[1]:.4f} MPa ({100 * errors[1]:+.1f} %)"
    )
    return ClaimFinding.of(max(map(abs, errors)) < WITHIN, figures)


def assess_mesh(path: Path) -> ClaimFinding:
    """Assess C2: find the number of elements from which the stress is within 5 % of the finest mesh.

    Parameters
    ----------
    path
        Table of `palpate design convergence --out`, for a half model.
    """
    meshes = [(HALVES * one.elements, one.stress_error) for one in read_meshes(path)]
    figures = ", ".join(f"{elements:g}: {100 * error:+.1f} %" for elements, error in meshes[:-1])
    figures = f"stress error by elements of the whole dome, relative to {meshes[-1][0]:g} elements: {figures}"
    first = next(number for number in range(len(meshes)) if all(abs(e) < WITHIN for _, e in meshes[number:]))
    if first == len(meshes) - 1:  # the finest is compared with itself alone
        open_ended = meshes[-1][0] <= PRINTED_ELEMENTS
        return (
            ClaimFinding(Verdict.UNDECIDED, figures, "needs finer meshes")
            if open_ended
            else ClaimFinding.of(False, figures)
        )
    return ClaimFinding.of(
        meshes[first][0] <= PRINTED_ELEMENTS, f"{figures}; within 5 % from {meshes[first][0]:g} elements upwards"
    )


def read_meshes(path: Path) -> list[MeshResult]:
    """Read the results of a convergence study, by ascending elements."""
    try:
        with path.open(newline="", encoding="utf-8") as file:
            rows = [[float(row[one.name]) for one in fields(MeshResult)] for row in csv.DictReader(file)]
        meshes = [MeshResult(int(cells), int(count), int(size), *rest) for cells, count, size, *rest in rows]
    except (OSError, KeyError, ValueError, TypeError) as error:
        raise PalpateError(
            f"{path} is not a table of `palpate design convergence`: {error}.",
            "Make it again: palpate design convergence --out FOLDER.",
            code="convergence-table-unreadable",
        ) from error
    if len(meshes) < 2:
        raise PalpateError(
            f"{path} has {len(meshes)} meshes; at least 2 are needed.",
            "Make it again with more meshes.",
            code="convergence-few-meshes",
        )
    return sorted(meshes, key=lambda one: one.elements)
