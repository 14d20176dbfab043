"""Press the paper's 12 geometries at its 7 tilts and print time, end and energy balance of each.

    python benchmarks/paper_presses.py --contact frictionless --workers 2 --out benchmarks/paper_presses.csv

A case already in the file is not solved again.
"""

from __future__ import annotations

import argparse
import csv
import os
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path

HEIGHTS, THICKNESSES, TILTS = (10, 20, 30), (1, 2, 3, 4), (0, 2, 4, 6, 8, 10, 12)
COLUMNS = [
    "height_mm",
    "thickness_mm",
    "tilt_deg",
    "contact",
    "ended",
    "ended_depth_mm",
    "jump_depth_mm",
    "cpu_s",
    "unknowns",
    "iterations",
    "worst_balance_percent",
]


def solve(height: float, thickness: float, tilt: float, contact: str) -> dict[str, object]:
    """Solve one press and describe it as a row."""
    import numpy as np

    from palpate.design import DomeSpec, build_skin
    from palpate.fea import WallSpec, solve_press
    from palpate.material import get_material
    from palpate.mesh import mesh_skin

    dome = build_skin(DomeSpec(height=height, thickness=thickness))
    wall = WallSpec(tilt_deg=tilt, contact=contact)
    press = solve_press(mesh_skin(dome), get_material("zaid_2024_ecoflex_00_30"), wall)
    stored = press.energy + press.contact_energy
    balance = np.abs(press.work[1:] / stored[1:] - 1).max()
    values = (height, thickness, tilt, contact, press.ended, press.ended_depth, press.jump_depth, press.cpu_s)
    return dict(zip(COLUMNS, (*values, press.unknowns, press.newton_iterations, 100 * balance), strict=True))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--contact", default="frictionless")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--tilts", type=float, nargs="*", default=TILTS)
    parser.add_argument("--out", type=Path, default=Path("paper_presses.csv"))
    given = parser.parse_args()
    for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"):
        os.environ[name] = "1"
    done = set()
    if given.out.exists():
        with given.out.open() as file:
            done = {
                (float(row["height_mm"]), float(row["thickness_mm"]), float(row["tilt_deg"]), row["contact"])
                for row in csv.DictReader(file)
            }
    cases = [(float(h), float(t), float(a), given.contact) for t in THICKNESSES for h in HEIGHTS for a in given.tilts]
    cases = [case for case in cases if case not in done]
    started = time.perf_counter()
    with given.out.open("a", newline="") as file, ProcessPoolExecutor(given.workers, get_context("spawn")) as pool:
        writer = csv.DictWriter(file, COLUMNS)
        if not done:
            writer.writeheader()
        for future in as_completed([pool.submit(solve, *case) for case in cases]):
            row = future.result()
            writer.writerow({k: f"{v:.5g}" if isinstance(v, float) else v for k, v in row.items()})
            file.flush()
            print(*row.values(), flush=True)
    print(f"{len(cases)} presses in {time.perf_counter() - started:.0f} s")


if __name__ == "__main__":
    main()
