"""Press a rigid ball into a dome, on the axis and beside it."""

import palpate as pp


def main() -> float:
    mesh = pp.mesh_skin(pp.build_skin(pp.DomeSpec(height=20, thickness=2)), pp.MeshSpec(cells=12))
    silicone = pp.get_material("zaid_2024_ecoflex_00_30")
    for offset in (0, 4):
        ball = pp.BallSpec(radius=8, offset=offset, depth=3.2, contact="frictionless")
        press = pp.solve_press(mesh, silicone, ball)
        print(f"{ball.label}: {press.force[-1, 2]:.4f} N along the axis, {press.force[-1, 0]:.4f} N across it")
    return float(press.force[-1, 2])


if __name__ == "__main__":
    main()
