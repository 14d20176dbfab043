"""Make the files of `examples/data`: python examples/make_data.py [FOLDER].

One sensor (dome H20 T2, 61 markers, the default camera) is built with random manufacturing deviations, photographed
at rest and pressed by a flat wall. A rubber is tested in three modes and held in tension. A chessboard is
photographed by a camera with known focal length and distortion. Tutorials and the inventory of tests use the files.
"""

import csv
import sys
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np

from palpate.calibration import ToleranceSpec, sample_deviation
from palpate.camera import CameraSpec, RenderSpec, render
from palpate.design import Design, DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import WallSpec, solve_press
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin
from palpate.simulation import SimulatedUnit

SEED = 20261126
DOME, MARKERS = DomeSpec(height=20, thickness=2), MarkerSpec(count=61)
FRICTION, DEPTHS = 1.2, (2.4, 4.0, 5.6)
LIGHT = RenderSpec(vignetting=0.2, unevenness=0.1, blur_px=0.7, noise=1.0, seed=SEED)
YEOH = (0.018, 0.0004, 0.00001)
"""Constants of the rubber, MPa."""
BOARD, SQUARE_MM = (9, 6), 25.0
"""Inner corners of the chessboard, and the side of its squares."""
LENS = {"fx": 520.0, "fy": 520.0, "cx": 322.0, "cy": 238.0, "k1": -0.21, "k2": 0.06}


def write_table(path: Path, head: str, rows: object) -> None:
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(head.split(","))
        writer.writerows(rows)


def make_recording(folder: Path) -> None:
    """Three rest images and 19 presses of three images each, with the pose and force of each."""
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(SEED)
    skin = build_skin(DOME)
    layout = place_markers(skin, MARKERS)
    write_table(
        folder.parent / "layout.csv", "x_mm,y_mm,z_mm", ([f"{x:.4f}" for x in row] for row in layout.positions)
    )
    deviation = sample_deviation(ToleranceSpec(), SEED, 1)
    scene = SimulatedUnit(Design.of_skin(skin, layout, CameraSpec()), deviation, LIGHT)
    mesh, material = mesh_skin(skin, MeshSpec()), get_material("zaid_2024_ecoflex_00_30")
    solved = [
        solve_press(mesh, material, WallSpec(tilt_deg=tilt, depth=5.6, depth_step=0.8, contact=FRICTION))
        for tilt in (0.0, 2.5, 5.0, 7.5, 10.0)
    ]
    rows: list[list[object]] = []
    for number in range(3):
        rows.append([f"{number:02d}.png", "rest", "", "", "", ""])
        noise = LIGHT.model_copy(update={"noise_seed": SEED + number})
        cv2.imwrite(str(folder / str(rows[-1][0])), render(scene.camera, scene.edges, noise))
    for press in range(1, 20):
        one, azimuth = solved[press % len(solved)], float(rng.uniform(0, 360))
        turned = replace(one, obstacle=one.obstacle.model_copy(update={"azimuth_deg": azimuth}))
        images = list(scene.render_press(turned))
        for depth in DEPTHS:
            step = int(np.argmin(np.abs(turned.depth - depth)))
            tilt = turned.obstacle.tilt_deg
            pose = tilt * np.cos(np.radians(azimuth)), tilt * np.sin(np.radians(azimuth)), turned.depth[step]
            force = float(np.linalg.norm(turned.force[step]))
            rows.append([f"{len(rows):02d}.png", press, *(f"{value:.4f}" for value in (*pose, force))])
            cv2.imwrite(str(folder / str(rows[-1][0])), images[step])
    write_table(folder / "poses.csv", "image,press,rx_deg,ry_deg,depth_mm,force_n", rows)
    cv2.imwrite(str(folder.parent / "rest.png"), cv2.imread(str(folder / "00.png"), cv2.IMREAD_GRAYSCALE))


def make_rubber(folder: Path) -> None:
    """Nominal stress of a Yeoh material in three modes with 0.5 % noise, and its relaxation."""
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(SEED + 1)
    strain = np.linspace(0.0, 1.5, 31)
    stretch = 1.0 + strain
    modes = {
        "uniaxial": (stretch**2 + 2 / stretch, stretch - stretch**-2),
        "equibiaxial": (2 * stretch**2 + stretch**-4, stretch - stretch**-5),
        "planar": (stretch**2 + 1 + stretch**-2, stretch - stretch**-3),
    }
    for mode, (invariant, factor) in modes.items():
        slope = sum((k + 1) * c * (invariant - 3) ** k for k, c in enumerate(YEOH))
        stress = 2 * factor * slope * (1 + 0.005 * rng.standard_normal(len(strain)))
        write_table(
            folder / f"{mode}.csv",
            "strain (mm/mm),stress (MPa)",
            ([f"{e:.4f}", f"{s:.6f}"] for e, s in zip(strain, stress, strict=True)),
        )
    time = np.geomspace(0.1, 1000, 40)
    held = 0.05 * (0.85 + 0.1 * np.exp(-time / 2) + 0.05 * np.exp(-time / 60)) * (1 + 0.002 * rng.standard_normal(40))
    write_table(
        folder / "relaxation.csv",
        "time (s),stress (MPa)",
        ([f"{t:.4f}", f"{s:.6f}"] for t, s in zip(time, held, strict=True)),
    )


def make_board(folder: Path) -> None:
    """Eight photographs of a chessboard, drawn at four times the size and reduced."""
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(SEED + 2)
    matrix = np.array([[LENS["fx"], 0, LENS["cx"]], [0, LENS["fy"], LENS["cy"]], [0, 0, 1]])
    size, fine, edge = (640, 480), 4, np.linspace(0, 1, 6)[:-1]
    border = np.concatenate(
        [np.c_[edge, 0 * edge], np.c_[1 + 0 * edge, edge], np.c_[1 - edge, 1 + 0 * edge], np.c_[0 * edge, 1 - edge]]
    )
    squares = [(i, j) for i in range(-1, BOARD[0]) for j in range(-1, BOARD[1]) if (i + j) % 2 == 0]
    for number in range(8):
        turn = rng.uniform(-0.45, 0.45, 3) * [1, 1, 0.5]
        middle = np.array([*((np.array(BOARD) - 1) * SQUARE_MM / 2), 0.0])
        rotation = cv2.Rodrigues(turn)[0]
        shift = np.array([*rng.uniform(-45, 45, 2), rng.uniform(330, 430)]) - rotation @ middle
        picture = np.full((size[1] * fine, size[0] * fine), 225, np.uint8)
        for i, j in squares:
            corners = np.c_[(border + np.array([i, j])) * SQUARE_MM, np.zeros(len(border))]
            seen = cv2.projectPoints(corners, turn, shift, matrix, np.array([LENS["k1"], LENS["k2"], 0, 0]))[0]
            points = np.round(((seen.reshape(-1, 2) + 0.5) * fine - 0.5) * 16).astype(np.int32)
            cv2.fillPoly(picture, [points], 30, cv2.LINE_8, 4)
        small = cv2.resize(picture, size, interpolation=cv2.INTER_AREA)
        cv2.imwrite(str(folder / f"{number}.png"), small)


def make_profile(folder: Path) -> None:
    """Meridian of the inner surface of the sensor, from the apex to the rim."""
    angle = np.linspace(0.0, np.pi / 2, 46)
    points = np.column_stack([20.0 * np.sin(angle), 20.0 * np.cos(angle)])
    write_table(folder / "profile.csv", "r_mm,z_mm", ([f"{value:.4f}" for value in row] for row in points))


def main(folder: Path) -> None:
    """Make every file in a folder."""
    make_recording(folder / "recording")
    make_rubber(folder / "rubber")
    make_board(folder / "board")
    make_profile(folder)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "data")
