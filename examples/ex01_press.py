"""Press one dome and read off force, stress and branch."""

from palpate.design import DomeSpec, build_skin
from palpate.fea import WallSpec, plot_press, solve_press
from palpate.material import get_material
from palpate.mesh import mesh_skin


def main() -> float:
    dome = build_skin(DomeSpec(height=20, thickness=3))
    wall = WallSpec(tilt_deg=5, depth=2.4, contact="frictionless")
    press = solve_press(mesh_skin(dome), get_material("zaid_2024_ecoflex_00_30"), wall)
    for depth, force, branch in zip(press.depth, press.force, press.branch, strict=True):
        print(f"{depth:.1f} mm: {force[2]:.4f} N along the axis, {force[1]:+.4f} N sideways, {branch}")
    print(press.ended)
    plot_press(press).savefig("ex01_press.svg")
    return float(press.force[-1, 2])


if __name__ == "__main__":
    main()
