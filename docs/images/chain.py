"""Draw the chain of palpate in one picture, from real results.

    palpate run studies/first.yaml && python docs/images/chain.py results/first/grid.csv

writes docs/images/chain.svg beside this file.
"""

import csv
import sys
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from palpate.camera import build_camera
from palpate.camera import camera_preset as camera_preset
from palpate.design import DomeSpec, MarkerLayout, MarkerSpec, build_skin, place_markers
from palpate.fea import Press, WallSpec, solve_press
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin

HERE = Path(__file__).parent
TILT_DEG = 10.0
SHADE = matplotlib.colormaps["viridis"]


def draw_surface(axes: Axes3D, press: Press, image: int) -> None:
    """Outer surface of both halves, coloured by the length of its displacement."""
    mesh = press.mesh
    u = press.displacement[image]
    length = np.linalg.norm(u, axis=1)
    top = max(length.max(), 1e-9)
    outline = [0, 1, 2, 5, 8, 7, 6, 3]
    for mirror in (1.0, -1.0):
        faces = (mesh.nodes + u)[mesh.outer_faces[:, outline]] * [mirror, 1, 1]
        colour = SHADE(length[mesh.outer_faces].mean(axis=1) / top) if image else (0.85, 0.87, 0.9, 1.0)
        axes.add_collection3d(Poly3DCollection(faces, facecolors=colour, edgecolors=(0, 0, 0, 0.25), linewidths=0.3))


def frame(axes: Axes3D, title: str) -> None:
    """Set the view of a 3-D panel and its title."""
    axes.set(xlim=(-20, 20), ylim=(-20, 20), zlim=(-6, 24), title=title)
    axes.set_box_aspect((40, 40, 30))
    axes.view_init(elev=18, azim=20)
    axes.set_axis_off()


def draw_wall(axes: Axes3D, press: Press) -> None:
    """The wall at full depth."""
    dome, tilt = press.mesh.skin, np.radians(press.obstacle.tilt_deg)
    normal = np.array([0, -np.sin(tilt), np.cos(tilt)])
    middle = np.array([0, 0, dome.center_z - press.depth[-1]]) + dome.outer_radius * normal
    along = np.array([0, np.cos(tilt), np.sin(tilt)])
    corners = [middle + 17 * (a * along + b * np.array([1, 0, 0])) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    axes.add_collection3d(Poly3DCollection([corners], facecolors=(0.2, 0.2, 0.25, 0.25), edgecolors="black"))


def draw_camera(axes: Axes, press: Press, markers: MarkerLayout) -> None:
    """Marker motion in the camera's image."""
    camera = build_camera(camera_preset("davis346"))
    pixels = camera.project(press.positions(markers.positions))
    start, motion = pixels[0], pixels[-1] - pixels[0]
    axes.quiver(*start.T, *motion.T, angles="xy", scale_units="xy", scale=1, width=0.006, color=SHADE(0.3))
    axes.plot(*start.T, ".", color="black", markersize=2)
    axes.set(
        xlim=(0, 346), ylim=(260, 0), aspect="equal", title="camera: motion of the markers", xticks=[], yticks=[]
    )


def draw_grid(axes: Axes, path: Path) -> None:
    """Error of every design of a finished study."""
    rows = list(csv.DictReader(path.open()))
    for thickness in sorted({row["thickness_mm"] for row in rows}, key=float):
        chosen = [row for row in rows if row["thickness_mm"] == thickness]
        axes.plot(
            [float(row["markers"]) for row in chosen],
            [float(row["rmse_deg"]) for row in chosen],
            "o-",
            label=f"T = {float(thickness):g} mm",
        )
    axes.set(xlabel="markers", ylabel="RMSE of the angle (°)", title="grid: error of each design", ylim=(0, None))
    axes.legend(frameon=False)
    axes.spines[["top", "right"]].set_visible(False)


def main(grid: Path) -> None:
    """Solve one press and draw design, press, camera and grid."""
    matplotlib.rcParams.update({"svg.hashsalt": "palpate", "font.size": 9})
    dome = build_skin(DomeSpec(height=20, thickness=2))
    markers = place_markers(dome, MarkerSpec(count=169))
    wall = WallSpec(tilt_deg=TILT_DEG, contact="no-slip")
    press = solve_press(mesh_skin(dome, MeshSpec()), get_material("zaid_2024_ecoflex_00_30"), wall)
    figure = Figure(figsize=(12, 3.1), layout="constrained")
    left = figure.add_subplot(1, 4, 1, projection="3d")
    draw_surface(left, press, 0)
    frame(left, "design and mesh: H 20, T 2 mm")
    pressed = figure.add_subplot(1, 4, 2, projection="3d")
    draw_surface(pressed, press, len(press.depth) - 1)
    draw_wall(pressed, press)
    frame(pressed, f"press: 8 mm at {TILT_DEG:g}°, {np.linalg.norm(press.force[-1]):.2f} N")
    draw_camera(figure.add_subplot(1, 4, 3), press, markers)
    draw_grid(figure.add_subplot(1, 4, 4), grid)
    figure.savefig(HERE / "chain.svg", metadata={"Date": None})


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("results/first/grid.csv"))
