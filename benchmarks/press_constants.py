"""Sensitivity of the tuned constants of presses: change of force at half and at twice each value.

    python benchmarks/press_constants.py [FILE ...]

It writes `docs/results/press_constants.csv`. Four presses of coarse domes (8 cells) are solved: without slip and
with friction (H20 T2, tilt 5°, 3.2 mm, with a derivative by thickness), without friction to 8 mm (H20 T1, tilt 0°),
and on the inverted branch (H20 T1). A figure is the greatest change of a force, of its derivative or of an end
depth over the greatest value; `time` is the ratio of CPU time. `fails` stands for a press that raises an error or
ends elsewhere.
"""

import csv
import sys
import time
from pathlib import Path

import numpy as np
from constants import SOURCE, TABLE, Value, constants, in_child, module_of, patch, scaled

from palpate.core import FloatArray, PalpateError
from palpate.design import DomeSpec, build_skin
from palpate.fea import Branch, WallSpec, solve_press
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, mesh_skin

RESULTS = TABLE.with_name("press_constants.csv")
FILES = ["mechanics/*.py", "fea/first_contact.py", "fea/inverted.py", "fea/monitor.py", "fea/variations.py"]
MATERIAL = get_material("zaid_2024_ecoflex_00_30")
MEDIUM, THIN = (build_skin(DomeSpec(height=20, thickness=thickness)) for thickness in (2, 1))
NOT_TUNED = {"_SIDES"}
STOP_S = 60
FIELDS = ["file", "constant", "value", "half", "double", "half_time", "double_time"]


def presses() -> list[FloatArray]:
    """Forces, derivatives of forces, and end depths of the four presses."""
    tilted, exact = {"tilt_deg": 5, "depth": 3.2}, SolverSpec(derivatives=("thickness",))
    mesh = mesh_skin(MEDIUM, MeshSpec(cells=8))
    thin = mesh_skin(THIN, MeshSpec(cells=8))
    found = [
        solve_press(mesh, MATERIAL, WallSpec(contact="no-slip", **tilted), exact),
        solve_press(mesh, MATERIAL, WallSpec(contact=0.5, **tilted), exact),
        solve_press(thin, MATERIAL, WallSpec(contact="frictionless", depth=8)),
        solve_press(thin, MATERIAL, WallSpec(contact="frictionless", depth=8), branch=Branch.INVERTED),
    ]
    parts = [press.force for press in found] + [press.derivative("thickness").force for press in found[:2]]
    return [*parts, np.array([press.depth[-1] for press in found])]


def run(change: tuple[Path, str, Value] | None) -> tuple[object, ...]:
    """Results as lists, and CPU time."""
    if change is not None:
        patch(module_of(change[0]), change[1], change[2])
    before = time.process_time()
    try:
        found = [part.tolist() for part in presses()]
    except (PalpateError, ArithmeticError, ValueError):
        return (None, 0.0)
    return found, time.process_time() - before


def compare(found: tuple[object, ...] | None, base: tuple[object, ...]) -> tuple[str, str]:
    """Greatest relative change, and ratio of times."""
    if found is None or found[0] is None:
        return "fails", ""
    pairs = [(np.array(one), np.array(other)) for one, other in zip(found[0], base[0], strict=True)]
    if any(one.shape != other.shape for one, other in pairs):
        return "fails", ""
    change = max(float(np.abs(one - other).max() / np.abs(other).max()) for one, other in pairs)
    return f"{change:.1e}", f"{found[1] / base[1]:.2f}"


def main(patterns: list[str]) -> None:
    """Rewrite the rows of some files."""
    paths = sorted({path for pattern in patterns for path in SOURCE.glob(pattern)})
    changed, rows = {path.relative_to(SOURCE).as_posix() for path in paths}, []
    if RESULTS.exists():
        with RESULTS.open(newline="", encoding="utf-8") as file:
            rows = [row for row in csv.DictReader(file) if row["file"] not in changed]
    presses()  # compiled code is loaded
    base = in_child(lambda: run(None))
    print(f"{base[1]:.1f} s", flush=True)
    for path in paths:
        for name, value in constants(path).items():
            if name in NOT_TUNED:
                continue
            row = {"file": path.relative_to(SOURCE).as_posix(), "constant": name, "value": str(value)}
            for column, factor in (("half", 0.5), ("double", 2.0)):
                change = path, name, scaled(value, factor)
                figures = compare(in_child(lambda change=change: run(change), STOP_S), base)
                row[column], row[column + "_time"] = figures
            print(*row.values(), sep=", ", flush=True)
            rows.append(row)
    with RESULTS.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, FIELDS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(sorted(rows, key=lambda row: (row["file"], row["constant"])))


if __name__ == "__main__":
    main(sys.argv[1:] or FILES)
