"""Press random designs under random walls and print how each ended.

Any exception, and any number that is not finite, is a fault.

    python benchmarks/random_designs.py --count 300 --out benchmarks/random_designs.csv

A design already in the file is not pressed again.
"""

from __future__ import annotations

import argparse
import csv
import time
from pathlib import Path

import numpy as np

from palpate.core import PalpateError
from palpate.design import DomeSpec, build_skin
from palpate.fea import WallSpec, solve_press
from palpate.material import get_material
from palpate.mesh import mesh_skin

SEED = 2026
COLUMNS = ("number height_mm base_mm thickness_mm tilt_deg contact ended ended_depth_mm cpu_s finite message").split()  # noqa: SIM905
LAWS: tuple[str | float, ...] = ("frictionless", 0.2, 0.5, "no-slip")


def draw(number: int) -> tuple[DomeSpec, WallSpec]:
    """Design and wall of a number."""
    rng = np.random.default_rng([SEED, number])
    height, base, thickness = rng.uniform(8, 32), rng.uniform(12, 25), rng.uniform(0.6, 5)
    tilt, law = rng.uniform(0, 15), LAWS[rng.integers(len(LAWS))]
    return DomeSpec(height=height, base_radius=base, thickness=thickness), WallSpec(tilt_deg=tilt, contact=law)


def press(number: int) -> dict[str, object]:
    """Press one design and describe it as a row."""
    spec, wall = draw(number)
    row: dict[str, object] = dict.fromkeys(COLUMNS, "")
    row |= {"number": number, "height_mm": round(spec.height, 3), "base_mm": round(spec.base_radius, 3)}
    row |= {"thickness_mm": round(spec.thickness, 3), "tilt_deg": round(wall.tilt_deg, 2), "contact": wall.contact}
    started = time.process_time()
    try:
        solved = solve_press(mesh_skin(build_skin(spec)), get_material("zaid_2024_ecoflex_00_30"), wall)
    except PalpateError as error:
        row |= {"ended": "refused", "message": str(error), "finite": True}
    except Exception as error:  # a fault is a row, so that the others are still pressed
        row |= {"ended": "fault", "message": f"{type(error).__name__}: {error}", "finite": False}
    else:
        fields = (solved.force, solved.energy, solved.work, solved.displacement, solved.peak_stress)
        finite = all(np.isfinite(values).all() for values in fields)
        row |= {"ended": str(solved.ended), "ended_depth_mm": round(solved.ended_depth, 4), "finite": finite}
        row |= {"message": solved.message}
    return row | {"cpu_s": round(time.process_time() - started, 1)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=300)
    parser.add_argument("--out", type=Path, default=Path("random_designs.csv"))
    given = parser.parse_args()
    done = set()
    if given.out.exists():
        with given.out.open() as file:
            done = {int(row["number"]) for row in csv.DictReader(file)}
    with given.out.open("a", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        if not done:
            writer.writeheader()
        for number in set(range(given.count)) - done:
            row = press(number)
            writer.writerow(row)
            file.flush()
            print(*row.values(), flush=True)


if __name__ == "__main__":
    main()
