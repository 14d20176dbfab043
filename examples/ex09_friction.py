"""What friction does to the markers, told as the tilt that would move them as much."""

import numpy as np

from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import WallSpec, solve_press
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin


def main() -> float:
    dome, silicone = build_skin(DomeSpec(height=20, thickness=3)), get_material("zaid_2024_ecoflex_00_30")
    mesh, points = mesh_skin(dome, MeshSpec(cells=9)), place_markers(dome, MarkerSpec(count=91)).positions

    def last_markers(tilt_deg: float, contact: str | float) -> np.ndarray:
        press = solve_press(mesh, silicone, WallSpec(tilt_deg=tilt_deg, depth=4, contact=contact))
        return press.positions(points)[-1]

    smooth = last_markers(4, "frictionless")
    per_degree = np.linalg.norm(last_markers(6, "frictionless") - smooth, axis=1).mean() / 2
    rough = {"friction 0.3": 0.3, "friction 1": 1.0, "no slip": "no-slip"}
    for name, contact in rough.items():
        moved = np.linalg.norm(last_markers(4, contact) - smooth, axis=1).mean()
        print(
            f"{name}: markers {moved:.3f} mm from where they would slide, as by {moved / per_degree:.1f} deg of tilt"
        )
    return float(moved / per_degree)


if __name__ == "__main__":
    main()
