"""What a press says of every number that Zaid et al. 2024 print and a press decides, under both contact laws.

The paper's 12 domes, pressed straight and under its steepest tilt (12°) to its 8 mm, without friction and without
slip; one row a press. What is printed, and which law it speaks for, stands in docs/published/paper_dome.md.

    python benchmarks/paper_numbers.py --out docs/results/paper_numbers.csv

A press already in the file is not solved again.
"""

from __future__ import annotations

import argparse
import csv
from itertools import product
from pathlib import Path

import numpy as np

from palpate.camera import build_camera
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import Press, WallSpec, solve_press
from palpate.fea.nodal_stress import clamped_solid
from palpate.material import get_material
from palpate.mesh import mesh_skin

HEIGHTS, THICKNESSES, TILTS = (10.0, 20.0, 30.0), (1.0, 2.0, 3.0, 4.0), (0.0, 12.0)
LAWS = ("frictionless", "no-slip")
FRAME, DROPPED = 0.8, 1.6
"""Depths in mm of the paper's first and second frame, both left out of its training."""


def stretches(press: Press) -> tuple[float, float]:
    """Least and greatest principal stretch of any Gauss point in any state that the press kept."""
    cells = clamped_solid(press).cells
    least, greatest = 1.0, 1.0
    for u in press.displacement:
        F = np.eye(3) + np.einsum("eai,eqaj->eqij", u[cells.nodes], cells.gradient)
        principal = np.linalg.svd(F, compute_uv=False)
        least, greatest = min(least, float(principal.min())), max(greatest, float(principal.max()))
    return least, greatest


def describe(height: float, thickness: float, tilt: float, law: str) -> dict[str, object]:
    """Solve one press and describe it as a row."""
    skin = build_skin(DomeSpec(height=height, thickness=thickness))
    wall = WallSpec(tilt_deg=tilt, contact=law)
    press = solve_press(mesh_skin(skin), get_material("zaid_2024_ecoflex_00_30"), wall)
    row: dict[str, object] = {"height_mm": height, "thickness_mm": thickness, "tilt_deg": tilt, "contact": law}
    row |= {"ended": str(press.ended), "ended_depth_mm": press.ended_depth, "branch": str(press.branch[-1])}
    row |= {"force_n": float(np.linalg.norm(press.force[-1])), "peak_stress_mpa": float(press.peak_stress.max())}
    row["min_stretch"], row["max_stretch"] = stretches(press)
    camera = build_camera()
    for count in (7, 169):
        dots = place_markers(skin, MarkerSpec(count=count)).positions
        places = press.positions(dots)
        travel = np.linalg.norm(places - dots, axis=-1).mean(axis=1)
        row[f"travel_{count}_mm"] = float(travel[-1])
        if count == 169:
            pixels = np.linalg.norm(camera.project(places) - camera.project(dots), axis=-1).mean(axis=1)
            for depth in (FRAME, DROPPED):
                at = int(np.abs(press.depth - depth).argmin())
                row[f"travel_at_{depth:g}_px"] = float(pixels[at])
                row[f"dots_at_{depth:g}"] = camera.project(places[at])
    return row


def press_dome(height: float, thickness: float, law: str) -> list[dict[str, object]]:
    """A row a tilt, with how far the dots of each lie from those of the straight press."""
    rows = [describe(height, thickness, tilt, law) for tilt in TILTS]
    for depth in (FRAME, DROPPED):
        dots = [row.pop(f"dots_at_{depth:g}") for row in rows]
        for row, each in zip(rows, dots, strict=True):
            row[f"from_straight_at_{depth:g}_px"] = float(np.linalg.norm(np.subtract(each, dots[0]), axis=-1).mean())
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--thicknesses", type=float, nargs="*", default=THICKNESSES)
    parser.add_argument("--out", type=Path, default=Path("paper_numbers.csv"))
    given = parser.parse_args()
    done = set()
    if given.out.exists():
        with given.out.open(encoding="utf-8") as file:
            rows = csv.DictReader(file)
            done = {(float(row["height_mm"]), float(row["thickness_mm"]), row["contact"]) for row in rows}
    for case in product(HEIGHTS, given.thicknesses, LAWS):
        if case in done:
            continue
        rows = press_dome(*case)
        new = not given.out.exists()
        with given.out.open("a", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, rows[0], lineterminator="\n")
            if new:
                writer.writeheader()
            for row in rows:
                writer.writerow({k: f"{v:.4g}" if isinstance(v, float) else v for k, v in row.items()})
                print(*row.values(), flush=True)


if __name__ == "__main__":
    main()
