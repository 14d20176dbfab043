"""Press whole domes whose wall is out of round, and say how far a half model misses them.

The imperfection is a smooth random field over the sphere (Legendre polynomials along the meridian times harmonics of
the azimuth up to order six, weights falling with the order), scaled to its greatest value. It moves the wall along
its radius and vanishes at the clamp. The paper's grid is solved on half models of perfect domes, so what counts is
the markers' asymmetry about the tilt plane, and their distance from the perfect dome's.

    python benchmarks/imperfect_domes.py --tilts 5 --out docs/results/imperfect_domes.csv

A case already in the file is not solved again.
"""

from __future__ import annotations

import argparse
import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.polynomial.legendre import legval

from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import Press, WallSpec, solve_press
from palpate.material import get_material
from palpate.mesh import Mesh, MeshSpec, mesh_skin

ORDERS = 6
COLUMNS = [
    "height_mm",
    "thickness_mm",
    "tilt_deg",
    "contact",
    "imperfection_mm",
    "seed",
    "depth_mm",
    "branch",
    "branch_perfect",
    "force_n",
    "force_off_percent",
    "asymmetry_rms_mm",
    "asymmetry_max_mm",
    "markers_off_rms_mm",
    "markers_off_max_mm",
    "ended",
    "cpu_s",
]


def disturb(mesh: Mesh, size: float, seed: int) -> Mesh:
    """The mesh with its wall moved along its radius by up to `size` mm."""
    rng = np.random.default_rng(seed)
    center = np.array([0.0, 0.0, mesh.skin.center_z])
    out = mesh.nodes - center
    direction = out / np.linalg.norm(out, axis=1, keepdims=True)
    azimuth = np.arctan2(direction[:, 1], direction[:, 0])
    polar = np.arccos(np.clip(direction[:, 2], -1, 1))
    place = polar / polar.max()
    field = np.zeros(len(out))
    for order in range(ORDERS + 1):
        for degree in range(1, ORDERS + 1):
            weight = rng.normal(size=2) / (1 + order + degree)
            along = legval(2 * place - 1, np.eye(ORDERS + 1)[degree]) * np.sin(polar) ** order
            field += along * (weight[0] * np.cos(order * azimuth) + weight[1] * np.sin(order * azimuth))
    field *= 1 - place**4
    return replace(mesh, nodes=mesh.nodes + (size * field / np.abs(field).max())[:, None] * direction)


def markers_of(press: Press, layout: np.ndarray) -> np.ndarray:
    """Displacement (n_images, m, 3) mm of the markers."""
    return press.positions(layout) - layout


def mirrored(layout: np.ndarray) -> np.ndarray:
    """Number of the marker that mirrors each one in the tilt plane x = 0, whose own x is reversed."""
    distance = np.linalg.norm((layout * [-1, 1, 1])[:, None] - layout[None], axis=-1)
    if distance.min(axis=1).max() > 1e-6:
        raise SystemExit("The layout has no mirror symmetry about the tilt plane.")
    return distance.argmin(axis=1)


def compare(whole: Press, perfect: Press, layout: np.ndarray, case: dict[str, object]) -> list[dict[str, object]]:
    """One row an image that both presses have."""
    moved, expected = markers_of(whole, layout), markers_of(perfect, layout)
    other = mirrored(layout)
    rows = []
    for image in range(1, min(len(whole.depth), len(perfect.depth))):
        if abs(whole.depth[image] - perfect.depth[image]) > 1e-6:
            continue
        lopsided = np.linalg.norm(moved[image] - moved[image][other] * [-1, 1, 1], axis=1)
        off = np.linalg.norm(moved[image] - expected[image], axis=1)
        force, right = whole.force[image, 2], perfect.force[image, 2]
        values = (whole.depth[image], whole.branch[image], perfect.branch[image], force, 100 * (force / right - 1))
        values += (_rms(lopsided), lopsided.max(), _rms(off), off.max(), whole.ended, whole.cpu_s)
        rows.append(case | dict(zip(COLUMNS[6:], values, strict=True)))
    return rows


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt((values**2).mean()))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--height", type=float, default=20.0)
    parser.add_argument("--thickness", type=float, default=1.0)
    parser.add_argument("--tilts", type=float, nargs="*", default=(5.0,))
    parser.add_argument("--contact", default="frictionless")
    parser.add_argument("--size", type=float, default=0.05)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--out", type=Path, default=Path("imperfect_domes.csv"))
    given = parser.parse_args()
    done = set()
    if given.out.exists():
        with given.out.open() as file:
            keys = ("height_mm", "thickness_mm", "tilt_deg", "imperfection_mm", "seed")
            done = {(*(float(row[key]) for key in keys), row["contact"]) for row in csv.DictReader(file)}
    dome = build_skin(DomeSpec(height=given.height, thickness=given.thickness))
    layout = place_markers(dome, MarkerSpec(count=169)).positions
    material = get_material("zaid_2024_ecoflex_00_30")
    with given.out.open("a", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        if not done:
            writer.writeheader()
        for tilt in given.tilts:
            wall = WallSpec(tilt_deg=tilt, contact=given.contact)
            perfect = None
            for seed in [None, *range(given.seeds)]:  # none: the perfect whole dome, what the mesh alone does
                size = 0.0 if seed is None else given.size
                number = -1 if seed is None else seed
                if (given.height, given.thickness, tilt, size, number, given.contact) in done:
                    continue
                perfect = perfect or solve_press(mesh_skin(dome), material, wall)
                mesh = mesh_skin(dome, MeshSpec(whole=True))
                whole = solve_press(mesh if seed is None else disturb(mesh, size, seed), material, wall)
                case = (given.height, given.thickness, tilt, given.contact, size, number)
                rows = compare(whole, perfect, layout, dict(zip(COLUMNS[:6], case, strict=True)))
                for row in rows:
                    writer.writerow({k: f"{v:.4g}" if isinstance(v, float) else v for k, v in row.items()})
                file.flush()
                print(list(rows[-1].values()), flush=True)


if __name__ == "__main__":
    main()
