"""Compare the marker maps that a network would see under the contact laws: no friction, Coulomb, no slip.

H 20 T 2, 169 markers, the paper's camera. One row a law, tilt and image: distance in px of the markers' images from
those of the frictionless press, the same over their mean travel, and how much of it a network could mistake for a
pose: the change of tilt and depth whose linear image, fitted by least squares, comes nearest to that distance.

    python benchmarks/friction_study.py --out docs/results/friction.csv

A tilt already in the file is not solved again.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

import numpy as np

from palpate.camera import build_camera
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import Press, WallSpec, solve_press
from palpate.material import get_material
from palpate.mesh import mesh_skin

LAWS: tuple[str | float, ...] = ("frictionless", 0.3, 1.0, "no-slip")
STEP_DEG = 1.0
"""Tilts on both sides by which the slope of the frictionless map is taken."""
COLUMNS = [
    "tilt_deg",
    "depth_mm",
    "contact",
    "force_n",
    "side_force_n",
    "travel_px",
    "off_rms_px",
    "off_max_px",
    "off_percent_of_travel",
    "mistaken_tilt_deg",
    "mistaken_depth_mm",
    "left_rms_px",
]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--height", type=float, default=20.0)
    parser.add_argument("--thickness", type=float, default=2.0)
    parser.add_argument("--tilts", type=float, nargs="*", default=(0.0, 5.0, 10.0))
    parser.add_argument("--out", type=Path, default=Path("friction.csv"))
    given = parser.parse_args()
    done = set()
    if given.out.exists():
        with given.out.open(encoding="utf-8") as file:
            done = {float(row["tilt_deg"]) for row in csv.DictReader(file)}
    study = Study(given.height, given.thickness)
    with given.out.open("a", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS)
        if not done:
            writer.writeheader()
        for tilt in given.tilts:
            if tilt in done:
                continue
            for row in study.rows(tilt):
                writer.writerow({k: f"{v:.4g}" if isinstance(v, float) else v for k, v in row.items()})
                print(*row.values(), flush=True)
            file.flush()


class Study:
    """One dome, its markers and the camera."""

    def __init__(self, height: float, thickness: float) -> None:
        dome = build_skin(DomeSpec(height=height, thickness=thickness))
        self.mesh, self.material = mesh_skin(dome), get_material("zaid_2024_ecoflex_00_30")
        self.layout, self.camera = place_markers(dome, MarkerSpec(count=169)).positions, build_camera()

    def press(self, tilt: float, contact: str | float) -> Press:
        return solve_press(self.mesh, self.material, WallSpec(tilt_deg=tilt, contact=contact))

    def images(self, press: Press) -> np.ndarray:
        """Displacement (n, 169, 2) px of the markers from rest."""
        return self.camera.project(press.positions(self.layout)) - self.camera.project(self.layout)

    def rows(self, tilt: float) -> list[dict[str, object]]:
        presses = {law: self.press(tilt, law) for law in LAWS}
        base = self.images(presses["frictionless"])
        depth = presses["frictionless"].depth
        down, up = (self.press(max(tilt + step, 0.0), "frictionless") for step in (-STEP_DEG, STEP_DEG))
        by_tilt = (self.images(up) - self.images(down)) / (up.obstacle.tilt_deg - down.obstacle.tilt_deg)
        by_depth = np.gradient(base, depth, axis=0)
        rows = []
        for law, press in presses.items():
            moved = self.images(press)
            for image in range(1, len(press.depth)):
                off = moved[image] - base[image]
                slopes = np.stack([by_tilt[image].ravel(), by_depth[image].ravel()], axis=1)
                mistaken, *_ = np.linalg.lstsq(slopes, off.ravel())
                left = (off.ravel() - slopes @ mistaken).reshape(off.shape)
                travel = float(np.linalg.norm(base[image], axis=1).mean())
                side = float(np.linalg.norm(press.force[image, :2]))
                force = (press.force[image, 2], side)
                values = (tilt, depth[image], law, *force, travel, _rms(off), np.linalg.norm(off, axis=1).max())
                values += (100 * _rms(off) / travel, mistaken[0], mistaken[1], _rms(left))
                rows.append(dict(zip(COLUMNS, values, strict=True)))
        return rows


def _rms(vectors: np.ndarray) -> float:
    return float(np.sqrt((vectors**2).sum(axis=1).mean()))


if __name__ == "__main__":
    main()
