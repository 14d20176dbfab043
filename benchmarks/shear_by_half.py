"""How far a wall may slide across its slope or twist until half a model with a linear antisymmetric part is wrong.

    python benchmarks/shear_by_half.py > RESULTS.csv

H20 T2, 5°, 169 markers, pressed 5 mm deep while the wall goes to 5 mm aside, or turns by 5°: markers of whole models,
against those of a half and its derivative by the slide or the turn, over the motion of the markers.
"""

import csv
import sys

import numpy as np

from palpate.design import DomeSpec, MarkerSpec, place_markers
from palpate.fea import Press, WallSpec, solve_press
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, locate_inner, mesh_skin

SKIN = DomeSpec().build()
MARKERS = place_markers(SKIN, MarkerSpec(count=169)).positions
MATERIAL = get_material("zaid_2024_ecoflex_00_30")
DEPTH, CELLS = 5.0, 16
ENDS = {
    "lateral_rate_across": ("mm", (0.25, 0.5, 1.0, 2.0, 3.5, 5.0)),
    "twist_rate_deg": ("deg", (0.5, 1.0, 2.0, 3.5, 5.0)),
}
"""Unit, and how far the wall has gone at full depth."""


def press(contact: str | float, whole: bool, **rates: float) -> Press:
    wall = WallSpec(tilt_deg=5, depth=DEPTH, depth_step=DEPTH, contact=contact, **rates)
    solver = SolverSpec() if whole else SolverSpec(derivatives=tuple(ENDS))
    return solve_press(mesh_skin(SKIN, MeshSpec(cells=CELLS, whole=whole)), MATERIAL, wall, solver)


def rate_of(half: Press, name: str) -> np.ndarray:
    """Derivative (n, 3) mm of the markers at full depth by a rate across the half's plane of symmetry."""
    turn, found = half.obstacle.turn(half.mesh), half.derivative(name)
    local = MARKERS @ turn
    other = local[:, :1] < 0
    field = locate_inner(half.mesh, np.where(other, local * [-1.0, 1.0, 1.0], local)).interpolate(
        found.displacement[-1]
    )
    assert found.across
    return np.where(other, field * [1.0, -1.0, -1.0], field) @ turn.T


def main() -> None:
    table = csv.writer(sys.stdout, lineterminator="\n")
    table.writerow(["contact", "path", "unit", "goes", "error_percent", "without_it_percent", "ended"])
    for contact in ("no-slip", 0.5):
        half, straight = press(contact, whole=False), press(contact, whole=True)
        for name, (unit, ends) in ENDS.items():
            slope = rate_of(half, name)
            for end in ends:
                whole = press(contact, whole=True, **{name: end / DEPTH})
                if whole.ended_depth < DEPTH:
                    table.writerow([contact, name, unit, end, "", "", str(whole.ended)])
                    continue
                # the whole's own straight press stands for the half's: what is compared is the slide alone
                truth, still = whole.positions(MARKERS)[-1] - MARKERS, straight.positions(MARKERS)[-1] - MARKERS
                size = np.sqrt((truth**2).sum())
                errors = [np.sqrt(((truth - still - part) ** 2).sum()) / size for part in (end / DEPTH * slope, 0.0)]
                table.writerow(
                    [contact, name, unit, end, *(f"{100 * error:.2f}" for error in errors), str(whole.ended)]
                )
                sys.stdout.flush()


if __name__ == "__main__":
    main()
