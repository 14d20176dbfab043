"""How well could any network do? The bound on the angle's error, from presses alone, before any training."""

import matplotlib.pyplot as plt
import numpy as np

from palpate.camera import build_camera
from palpate.datasets import DatasetSpec
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import WallSpec, solve_press
from palpate.learn import compute_error_bounds
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin
from palpate.surrogate import build_field


def main() -> float:
    dome, silicone = build_skin(DomeSpec(height=20, thickness=3)), get_material("zaid_2024_ecoflex_00_30")
    mesh = mesh_skin(dome, MeshSpec(cells=9))
    walls = [WallSpec(tilt_deg=tilt, depth=4, contact="frictionless") for tilt in (0, 6, 12)]
    presses = [solve_press(mesh, silicone, wall) for wall in walls]
    bounds = {}
    for count in (7, 37, 169):
        field = build_field(presses, place_markers(dome, MarkerSpec(count=count)))
        for limit in compute_error_bounds(field, build_camera(), DatasetSpec()):
            bounds[count, limit.depth_mm] = limit.least_squares_deg
            print(
                f"{count} markers, {limit.depth_mm:.1f} mm: least squares {limit.least_squares_deg:.2f} deg, "
                f"posterior mean {limit.pitman_deg:.2f} deg"
            )
    figure, axis = plt.subplots(figsize=(5, 3), layout="constrained")
    for count in (7, 37, 169):
        depths = [depth for number, depth in bounds if number == count]
        axis.plot(depths, [bounds[count, depth] for depth in depths], "o-", label=f"{count} markers")
    axis.set(xlabel="depth, mm", ylabel="least-squares bound, deg", ylim=(0, None))
    axis.legend()
    figure.savefig("ex06_limit.svg")
    deepest = np.array([bounds[count, 4.0] for count in (7, 169)])
    print(f"169 markers instead of 7 are worth a factor of {deepest[0] / deepest[1]:.1f}")
    return float(deepest[1])


if __name__ == "__main__":
    main()
