"""Flat branch of six domes against an independent axisymmetric code: force, energy, probes within 2 %."""

import csv
from pathlib import Path

import numpy as np
import pytest

from palpate.design import DomeSpec, build_dome
from palpate.fea import Branch, WallSpec, solve_press
from palpate.material import get_material
from palpate.mesh import mesh_dome

DATA = Path(__file__).parent / "data"
FLAT_GAP_MM = 0.05


@pytest.mark.slow
@pytest.mark.parametrize(
    ("height", "thickness", "flat_to"), [(20, 1, 7.2), (20, 2, 8), (20, 3, 8), (20, 4, 8), (10, 2, 6.4), (30, 2, 8)]
)
def test_flat_branch(height: int, thickness: int, flat_to: float) -> None:
    with (DATA / f"dome_H{height}_T{thickness}.csv").open() as file:
        rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
    rows = [row for row in rows if row["apex_gap_mm"] < FLAT_GAP_MM]
    at = [row["d_mm"] for row in rows]
    dome = build_dome(DomeSpec(height=height, thickness=thickness))
    wall = WallSpec(contact="frictionless", depth=flat_to)
    press = solve_press(mesh_dome(dome), get_material("zaid_2024_ecoflex_00_30"), wall)
    assert set(press.branch) == {Branch.FLAT}
    rim = np.arccos((dome.radius - dome.height) / dome.radius)
    polar = rim * np.array([0.25, 0.5, 0.75])
    probes = np.stack([0 * polar, dome.radius * np.sin(polar), dome.center_z + dome.radius * np.cos(polar)], -1)
    moved = press.positions(probes) - probes

    def reference(column: str) -> np.ndarray:
        return np.interp(press.depth[1:], at, [row[column] for row in rows])

    assert press.force[1:, 2] == pytest.approx(reference("force_N"), rel=0.02)
    assert press.energy[1:] == pytest.approx(reference("strain_energy_mJ"), rel=0.02)
    for k, name in enumerate(("q25", "q50", "q75")):
        gap = np.hypot(
            moved[1:, k, 1] - reference(f"inner_{name}_ur"), moved[1:, k, 2] - reference(f"inner_{name}_uz")
        )
        assert (gap < 0.02 * press.depth[1:]).all()
