"""Press six domes of the paper's grid by palpate and by CalculiX on the same mesh, and compare every image.

    python benchmarks/against_calculix.py RESULTS.csv      solve what RESULTS.csv lacks, then print the tables
    python benchmarks/against_calculix.py RESULTS.csv -t   print the tables only
    python benchmarks/against_calculix.py -r               refine both meshes at H20 T3 10°, and print

Frictionless, 169 markers, 20-node bricks (C3D20R) in CalculiX where palpate has 27-node ones. A case is written when
both programs have finished it, so a stopped run goes on where it was. Run it alone on a machine, with one thread.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np

from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import CalculixSpec, DeckSpec, Dialect, Press, WallSpec, solve_press, solve_press_calculix
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin

CASES = [(20, 3, 10), (20, 2, 5), (20, 4, 12), (10, 3, 0), (30, 2, 5), (20, 1, 5)]
"""Height mm, thickness mm, tilt deg."""

COLUMNS = [
    "height_mm",
    "thickness_mm",
    "tilt_deg",
    "cells",
    "depth_mm",
    "force_palpate_n",
    "force_calculix_n",
    "force_deviation_percent",
    "energy_deviation_percent",
    "marker_rms_mm",
    "marker_max_mm",
    "branch_palpate",
    "branch_calculix",
    "cpu_palpate_s",
    "cpu_calculix_s",
    "unknowns_palpate",
    "unknowns_calculix",
    "iterations_palpate",
    "iterations_calculix",
    "ended_palpate",
    "ended_calculix",
]


def main() -> None:
    if sys.argv[1] == "-r":
        print_refinement()
        return
    path = Path(sys.argv[1])
    if "-t" not in sys.argv[2:]:
        warm_up()
        for case in CASES:
            if case not in finished(path):
                append(path, compare(*case))
                print(f"H{case[0]} T{case[1]} {case[2]}° done", flush=True)
    print_tables(path)


def warm_up() -> None:
    """Load the compiled kernels, so that no case pays for them."""
    mesh = mesh_skin(build_skin(DomeSpec()), MeshSpec(cells=4))
    solve_press(mesh, get_material("zaid_2024_ecoflex_00_30"), WallSpec(depth=0.8, contact="frictionless"))


def compare(height: float, thickness: float, tilt: float) -> list[dict[str, object]]:
    dome = build_skin(DomeSpec(height=height, thickness=thickness))
    mesh = mesh_skin(dome, MeshSpec())
    material = get_material("zaid_2024_ecoflex_00_30")
    wall = WallSpec(tilt_deg=tilt, contact="frictionless")
    ours = solve_press(mesh, material, wall)
    theirs = solve_press_calculix(mesh, material, wall)
    markers = place_markers(dome, MarkerSpec(count=169)).positions
    away = np.linalg.norm(followed(ours, theirs, markers) - followed(theirs, ours, markers), axis=-1)
    common = {
        "height_mm": height,
        "thickness_mm": thickness,
        "tilt_deg": tilt,
        "cells": len(mesh.cells),
        "cpu_palpate_s": round(ours.cpu_s, 2),
        "cpu_calculix_s": round(theirs.cpu_s, 2),
        "unknowns_palpate": ours.unknowns,
        "unknowns_calculix": theirs.unknowns,
        "iterations_palpate": ours.newton_iterations,
        "iterations_calculix": theirs.newton_iterations,
        "ended_palpate": f"{ours.ended} at {ours.ended_depth:.2f} mm",
        "ended_calculix": f"{theirs.ended} at {theirs.ended_depth:.2f} mm",
    }
    return [
        {
            **common,
            "depth_mm": round(float(ours.depth[k]), 4),
            "force_palpate_n": f"{ours.force[k, 2]:.6f}",
            "force_calculix_n": f"{theirs.force[k, 2]:.6f}",
            "force_deviation_percent": f"{100 * (ours.force[k, 2] / theirs.force[k, 2] - 1):.3f}",
            "energy_deviation_percent": f"{100 * (ours.energy[k] / theirs.energy[k] - 1):.3f}",
            "marker_rms_mm": f"{np.sqrt((away[k] ** 2).mean()):.5f}",
            "marker_max_mm": f"{away[k].max():.5f}",
            "branch_palpate": ours.branch[k],
            "branch_calculix": theirs.branch[k],
        }
        for k in range(1, shared(ours, theirs))
    ]


def shared(a: Press, b: Press) -> int:
    """Number of first images at the same depths."""
    count = min(len(a.depth), len(b.depth))
    return int(np.sum(np.abs(a.depth[:count] - b.depth[:count]) < 1e-6))


def followed(press: Press, other: Press, markers: np.ndarray) -> np.ndarray:
    return press.positions(markers)[: shared(press, other)]


def finished(path: Path) -> set[tuple[float, ...]]:
    return {(float(row["height_mm"]), float(row["thickness_mm"]), float(row["tilt_deg"])) for row in read(path)}


def read(path: Path) -> list[dict[str, str]]:
    if not path.is_file():
        return []
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def append(path: Path, rows: list[dict[str, object]]) -> None:
    """All rows of a case in one go."""
    before = path.read_text() if path.is_file() else ",".join(COLUMNS) + "\n"
    part = path.with_suffix(".part")
    with part.open("w", newline="") as file:
        file.write(before)
        csv.DictWriter(file, COLUMNS, lineterminator="\n").writerows(rows)
    part.replace(path)


def print_tables(path: Path) -> None:
    rows = read(path)
    print("| case | depth mm | force N palpate | CalculiX | force | energy | markers rms mm | max mm | branches |")
    print("|---|---|---|---|---|---|---|---|---|")
    for row in rows:
        branches = row["branch_palpate"] if row["branch_palpate"] == row["branch_calculix"] else "differ"
        print(
            f"| {name(row)} | {row['depth_mm']} | {float(row['force_palpate_n']):.4f} | "
            f"{float(row['force_calculix_n']):.4f} | {float(row['force_deviation_percent']):+.1f} % | "
            f"{float(row['energy_deviation_percent']):+.1f} % | {float(row['marker_rms_mm']):.3f} | "
            f"{float(row['marker_max_mm']):.3f} | {branches} |"
        )
    print("\n| case | cells | unknowns | iterations | CPU-s palpate | CalculiX | ratio | ended palpate | CalculiX |")
    print("|---|---|---|---|---|---|---|---|---|")
    for row in {name(row): row for row in rows}.values():
        ratio = float(row["cpu_calculix_s"]) / float(row["cpu_palpate_s"])
        print(
            f"| {name(row)} | {row['cells']} | {row['unknowns_palpate']}, {row['unknowns_calculix']} | "
            f"{row['iterations_palpate']}, {row['iterations_calculix']} | {row['cpu_palpate_s']} | "
            f"{row['cpu_calculix_s']} | {ratio:.1f} | {row['ended_palpate']} | {row['ended_calculix']} |"
        )


def print_refinement() -> None:
    """Where the deviation comes from: finer meshes, a softer volume, a harder contact; markers against the finest."""
    dome, wall = build_skin(DomeSpec(height=20, thickness=3)), WallSpec(tilt_deg=10, contact="frictionless")
    ecoflex, markers = get_material("zaid_2024_ecoflex_00_30"), place_markers(dome, MarkerSpec(count=169)).positions
    hard = CalculixSpec(deck=DeckSpec(dialect=Dialect.CALCULIX, penalty=5.0))
    warm_up()
    print("| program | cells | K/mu | force N, 3.2 mm | 5.6 mm | 8.0 mm | energy mJ | markers rms / max µm | CPU-s |")
    print("|---|---|---|---|---|---|---|---|---|")
    finest = None
    for program, cells, ratio, spec in [
        ("palpate", 32, 2000, None),
        ("palpate", 24, 2000, None),
        ("palpate", 16, 2000, None),
        ("CalculiX", 16, 2000, None),
        ("CalculiX", 24, 2000, None),
        ("palpate", 16, 100, None),
        ("CalculiX", 16, 100, None),
        ("CalculiX, penalty 5 MPa/mm", 16, 2000, hard),
    ]:
        mesh, material = mesh_skin(dome, MeshSpec(cells=cells)), ecoflex.with_bulk_ratio(ratio)
        ours = program == "palpate"
        press = solve_press(mesh, material, wall) if ours else solve_press_calculix(mesh, material, wall, spec)
        at = press.positions(markers)[10]
        finest = at if finest is None else finest
        away = 1000 * np.linalg.norm(at - finest, axis=-1)
        force = " | ".join(f"{press.force[k, 2]:.4f}" for k in (4, 7, 10))
        print(
            f"| {program} | {len(mesh.cells)} | {ratio} | {force} | {press.energy[10]:.4f} | "
            f"{np.sqrt((away**2).mean()):.0f} / {away.max():.0f} | {press.cpu_s:.1f} |",
            flush=True,
        )


def name(row: dict[str, str]) -> str:
    return f"H{row['height_mm']} T{row['thickness_mm']} {row['tilt_deg']}°"


if __name__ == "__main__":
    main()
