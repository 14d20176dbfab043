"""Press the paper's T = 1 mm domes with and without adhesion: which state they take.

    python docs/images/which_state.py

writes theory_which_state.svg beside this file and prints the table of the page; some ten CPU-minutes.
"""

from itertools import product
from pathlib import Path

import matplotlib
from matplotlib.figure import Figure

from palpate.design import DomeSpec, build_skin
from palpate.fea import Branch, Press, WallSpec, solve_press
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import mesh_skin

HERE = Path(__file__).parent
MATERIAL = get_material("zaid_2024_ecoflex_00_30")
LAWS = ("frictionless", "no-slip")
STYLES = {"default": "C0-", "adhesion: 0": "C1-", "inverted": "C2--"}


def press(height: float, tilt: float, law: str, how: str) -> Press:
    """One press of a T = 1 mm dome: by default, without adhesion, or inverted."""
    mesh = mesh_skin(build_skin(DomeSpec(height=height, thickness=1)))
    wall = WallSpec(tilt_deg=tilt, contact=law, depth_step=0.4)
    solver = SolverSpec(adhesion=0) if how == "adhesion: 0" else SolverSpec()
    return solve_press(mesh, MATERIAL, wall, solver, Branch.INVERTED if how == "inverted" else Branch.FLAT)


def row(height: float, tilt: float, law: str, presses: dict[str, Press]) -> str:
    """One row of the table in Markdown."""
    flat, free, inverted = (presses[how] for how in STYLES)
    kpa = 1e3 * flat.stabilisation_tension.max()
    jump = "none" if free.jump_depth != free.jump_depth else f"{free.jump_depth:.2f}"
    first = f"{inverted.depth[0]:.2f}" if inverted.depth[0] > 0 else "none"
    forces = " | ".join(f"{one.force[-1, 2]:.4f}, {one.branch[-1]}, {one.depth[-1]:.1f}" for one in (flat, free))
    return f"| H{height:g} | {tilt:g} | {law} | {kpa:.2f} | {forces} | {jump} | {first} |"


def main() -> None:
    """Solve all, print the table, draw H20 at tilt 0."""
    figure = Figure(figsize=(7.2, 2.8), layout="constrained")
    axes = dict(zip(LAWS, figure.subplots(1, 2, sharey=True), strict=True))
    for height, tilt, law in product((10, 20, 30), (0, 5), LAWS):
        presses = {how: press(height, tilt, law, how) for how in STYLES}
        print(row(height, tilt, law, presses), flush=True)
        if (height, tilt) == (20, 0):
            for how, one in presses.items():
                axes[law].plot(one.depth, one.force[:, 2], STYLES[how], label=how)
            axes[law].set(xlabel="depth (mm)", title=law)
    axes[LAWS[0]].set(ylabel="force (N)")
    axes[LAWS[0]].legend(frameon=False)
    matplotlib.rcParams["svg.hashsalt"] = "palpate"
    figure.savefig(HERE / "theory_which_state.svg", metadata={"Date": None})


if __name__ == "__main__":
    main()
