"""Press a wall into a dome, slide it aside and back, and draw how it sticks, glides and sticks again."""

import matplotlib.pyplot as plt
import numpy as np

import palpate as pp
from palpate.fea.route import RouteSpec
from palpate.mechanics import SolverSpec


def main() -> float:
    mesh = pp.mesh_skin(pp.build_skin(pp.DomeSpec(height=20, thickness=2)), pp.MeshSpec(cells=6, whole=True))
    silicone = pp.get_material("zaid_2024_ecoflex_00_30")
    figure, axes = plt.subplots(figsize=(6, 3.5), layout="constrained")
    for friction in (0.3, 0.6):
        # depth, x, y in mm: down, aside, back
        there_and_back = [[2], [2, 2], [2, 0]]
        wall = RouteSpec(waypoints=there_and_back, contact=friction, depth_step=0.5)
        press = pp.solve_press(mesh, silicone, wall, SolverSpec(adhesion=0))
        aside = np.array([wall.waypoint(length).x_mm for length in press.depth])
        sliding = press.depth >= 2
        share = -press.force[sliding, 0] / press.force[sliding, 2]
        axes.plot(aside[sliding], share, label=f"µ = {friction}")
        lost = press.dissipation[-1]
        print(f"µ = {friction}: pulls with up to {share.max():.3f} of its force, {lost:.3f} mJ lost to friction")
    axes.set(xlabel="wall aside, mm", ylabel="force aside / force down")
    axes.legend(frameon=False)
    figure.savefig("ex16_slide.svg")
    return float(share.max())


if __name__ == "__main__":
    main()
