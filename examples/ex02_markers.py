"""Follow markers through a press and see them in the camera."""

import matplotlib.pyplot as plt
import numpy as np

from palpate.camera import build_camera
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import WallSpec, solve_press
from palpate.material import get_material
from palpate.mesh import mesh_skin


def main() -> float:
    dome = build_skin(DomeSpec(height=20, thickness=3))
    layout = place_markers(dome, MarkerSpec(count=37)).positions
    wall = WallSpec(tilt_deg=5, azimuth_deg=30, depth=2.4)
    press = solve_press(mesh_skin(dome), get_material("zaid_2024_ecoflex_00_30"), wall)
    camera = build_camera()
    moved = camera.project(press.positions(layout)) - camera.project(layout)
    travel = np.linalg.norm(moved, axis=-1)
    for depth, length in zip(press.depth, travel, strict=True):
        print(f"{depth:.1f} mm: markers move {length.mean():.2f} px, at most {length.max():.2f} px")
    figure, axis = plt.subplots(figsize=(5, 4), layout="constrained")
    axis.plot(*(camera.project(layout).T), "o", color="#888888", ms=3)
    axis.quiver(*camera.project(layout).T, *moved[-1].T, angles="xy", scale_units="xy", scale=0.2, color="#00538c")
    axis.set(xlim=(0, camera.width_px), ylim=(camera.height_px, 0), aspect="equal")
    axis.set(xlabel="u (px)", ylabel="v (px)", title="displacements of the markers, five times enlarged")
    figure.savefig("ex02_markers.svg")
    return float(travel[-1].mean())


if __name__ == "__main__":
    main()
