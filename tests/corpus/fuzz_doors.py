"""Doors of the command line that read a file: how a right file is drawn, and how it is read."""

from __future__ import annotations

import json
import shutil
import sys
import tempfile
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any
from unittest import mock

import cv2
import h5py
import numpy as np
import pyarrow
import pyarrow.parquet
import zarr
from PIL import Image

sys.path.append(str(Path(__file__).parents[1]))
sys.path.append(str(Path(__file__).parents[1] / "unit" / "cli"))
sys.path.append(str(Path(__file__).parents[1] / "unit" / "datasets"))
sys.path.append(str(Path(__file__).parents[1] / "unit" / "design"))
sys.path.append(str(Path(__file__).parents[1] / "unit" / "learn"))

import synthetic
import test_camera_files as cameras
import test_drawing_points as drawings
import test_image_files as videos
import test_profile as profiles
import test_read_rosbag as bags
import test_recording_files as recordings
from doors import furnish
from palpate_benchmark import PRESETS, read_baseline_spec, read_benchmark_spec

from palpate.calibration import UNIT_PARAMETERS, IdentifiedUnit, ScalarEstimate, read_unit, write_unit
from palpate.calibration.mounting import MOUNTING_PARAMETERS, Mounting
from palpate.calibration.unit_model import UnitPosterior
from palpate.camera import CameraSpec, open_source, read_calibration, read_image
from palpate.cli import main
from palpate.core import ArtefactStore, PalpateError
from palpate.core.progress import Progress
from palpate.core.state import State
from palpate.datasets import read_dataset, read_recording, write_dataset
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import WallSpec, read_press, solve_press, write_press
from palpate.learn import RecordingSpec, read_model, read_pretrained, train_on_recording, write_model
from palpate.material import get_material, write_material
from palpate.mesh import MeshSpec, mesh_skin
from palpate.optimise import read_requirements
from palpate.sensor import read_ground_truth
from palpate.study import read_study
from palpate.surrogate import read_twin
from palpate.viewer.results import read_design, read_results

IMAGES = np.random.default_rng(1).integers(0, 255, (24, 16, 20), np.uint8)
POSES = np.random.default_rng(2).uniform(-9, 9, (24, 2))
PRESS = np.arange(24) // 3
SET_SPEC = PRESETS["tiny"].model_dump_json()
Read = Callable[[Path], object]
STUDY = "name: small\ndesigns:\n  heights: [20 mm]\n  markers: [7, 19]\nmesh: {cells: 8}\ntilts_deg: [0, 3]\n"


@cache
def house() -> dict[str, Path]:
    """Right inputs of every verb, drawn once."""
    folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
    made = furnish(folder)
    table(TRUTH, folder / "truths.csv")
    table(READINGS, folder / "readings.csv")
    return made | {"truths": folder / "truths.csv", "readings": folder / "readings.csv"}


def copy_of(name: str) -> Read:
    return lambda path: path.write_bytes(house()[name].read_bytes())


def text(content: str) -> Read:
    return lambda path: path.write_text(content, encoding="utf-8")


def table(columns: dict[str, Any], path: Path) -> None:
    """A table as CSV, JSON lines or Parquet, by the ending."""
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    if path.suffix == ".parquet":
        pyarrow.parquet.write_table(pyarrow.Table.from_pylist(rows), path)
    elif path.suffix == ".jsonl":
        path.write_text("".join(json.dumps(row) + "\n" for row in rows))
    else:
        lines = [";".join(columns), *(";".join(str(cell) for cell in row.values()) for row in rows)]
        path.write_text("\n".join(lines) + "\n")


STRAIN = np.linspace(0, 1, 40).tolist()
CURVE = {"strain (mm/mm)": STRAIN, "stress (MPa)": [0.1 * x for x in STRAIN]}
TRUTH = {
    "image": ["0.png", *(f"{k}.png" for k in range(1, 13))],
    "press": ["rest", *(str(k // 2) for k in range(1, 13))],
    "rx_deg": [0.0, *POSES[:12, 0].round(3).tolist()],
    "ry_deg": [0.0, *POSES[:12, 1].round(3).tolist()],
    "depth_mm": [0.0, *np.linspace(2, 4, 12).round(3).tolist()],
}
READINGS = {name: TRUTH[name][1:] for name in ("image", "rx_deg", "ry_deg", "depth_mm")}


def write_h5(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file["images"], file["rx_deg"], file["depth_mm"], file["press"] = IMAGES, POSES[:, 0], POSES[:, 1], PRESS


def write_npz(path: Path) -> None:
    np.savez(path, images=IMAGES, rx_deg=POSES[:, 0], depth_mm=POSES[:, 1], press=PRESS)


def write_zarr(path: Path) -> None:
    root = zarr.open_group(str(path), mode="w")
    for name, values in {"images": IMAGES, "rx_deg": POSES[:, 0], "depth_mm": POSES[:, 1], "press": PRESS}.items():
        root[name] = values


def write_robomimic(path: Path) -> None:
    with h5py.File(path, "w") as file:
        for press in range(8):
            rows = press == PRESS
            file[f"data/demo_{press}/obs/tactile_image"] = np.repeat(IMAGES[rows][..., None], 3, axis=3)
            file[f"data/demo_{press}/obs/pose"] = POSES[rows]
            file[f"data/demo_{press}/obs/pose"].attrs["columns"] = ("rx_deg", "depth_mm")


def write_toolkit(path: Path) -> None:
    """A folder of the TacTip toolkit: a table, and images in a folder of their own."""
    (path / "sensor_images").mkdir(parents=True)
    names = [f"image_{k}.png" for k in range(24)]
    for name, image in zip(names, IMAGES, strict=True):
        cv2.imwrite(str(path / "sensor_images" / name), image)
    columns = {"sensor_image": names, "pose_4": POSES[:, 0], "pose_3": POSES[:, 1]}
    table({name: list(values) for name, values in columns.items()}, path / "targets.csv")


def write_videos(path: Path) -> None:
    """A table that names a video and a frame for each row."""
    path.mkdir()
    for press in range(8):
        videos.write_video(path / f"press_{press}.mp4", "libx264", list(range(3)))
    names = [f"press_{press}.mp4" for press in PRESS]
    columns = {"video": names, "frame": [k % 3 for k in range(24)], "press": PRESS.tolist()}
    columns |= {"rx_deg": POSES[:, 0].tolist(), "depth_mm": POSES[:, 1].tolist()}
    table(columns, path / "poses.csv")


def write_lerobot(path: Path, version: int) -> None:
    recordings.write_lerobot(path, ("observation.images.tactile",), version)


def write_lerobot_videos(path: Path) -> None:
    """A dataset of version 2.1 with one video per episode."""
    recordings.write_lerobot(path, ("observation.images.tactile",), 2)
    about = json.loads((path / "meta" / "info.json").read_text())
    about["features"]["observation.images.tactile"]["dtype"] = "video"
    (path / "meta" / "info.json").write_text(json.dumps(about))
    folder = path / "videos" / "chunk-000" / "observation.images.tactile"
    folder.mkdir(parents=True)
    for press in range(recordings.PRESSES):
        videos.write_video(folder / f"episode_{press:06d}.mp4", "libx264", list(range(3)))


def write_bag(kind: str, path: Path) -> None:
    with mock.patch.object(bags, "COUNT", 64):
        bags.make(path, kind)


def write_boards(path: Path) -> None:
    """Four views of a chessboard of 6 × 5 corners."""
    path.mkdir()
    board = np.pad(np.kron(np.indices((6, 7)).sum(0) % 2, np.ones((16, 16))) * 200 + 30, 24, constant_values=230)
    height, width = board.shape
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
    for number in range(4):
        tilted = corners + np.random.default_rng(number).uniform(-14, 14, (4, 2)).astype(np.float32)
        turned = cv2.getPerspectiveTransform(corners, tilted)
        image = cv2.warpPerspective(board.astype(np.uint8), turned, (width, height), borderValue=230)
        cv2.imwrite(str(path / f"{number}.png"), image)


def write_step(path: Path) -> None:
    import build123d as cad

    ball = cad.Pos(0, 0, profiles.CENTRE) * (cad.Sphere(profiles.RADIUS + 2) - cad.Sphere(profiles.RADIUS))
    below = cad.Pos(0, 0, -50) * cad.Box(200, 200, 100)
    cad.export_step(ball - below, str(path))


def write_identified(path: Path) -> None:
    skin = build_skin(DomeSpec())
    markers = place_markers(skin, MarkerSpec(count=37)).positions
    size = len(UNIT_PARAMETERS) + len(MOUNTING_PARAMETERS)
    camera = State(UNIT_PARAMETERS, np.zeros(len(UNIT_PARAMETERS)))
    mounting = Mounting(State(MOUNTING_PARAMETERS, np.zeros(len(MOUNTING_PARAMETERS))), 0.01 * np.eye(size))
    belief = UnitPosterior(CameraSpec(), markers[:, :2] * 4 + 150, camera, 0.01 * np.eye(len(UNIT_PARAMETERS)))
    write_unit(path, IdentifiedUnit(skin.spec_data, markers, belief, mounting, ScalarEstimate(1.02, 0.01)))


def write_recorded(path: Path) -> None:
    spec, store = RecordingSpec(estimators="ridge"), ArtefactStore(path.parent / "store")
    write_model(path, train_on_recording(read_recording(house()["recording"]), spec, store, Progress()).model)


def write_pressed(path: Path) -> None:
    mesh = mesh_skin(build_skin(DomeSpec()), MeshSpec(cells=4))
    write_press(path, solve_press(mesh, get_material("zaid_2024_ecoflex_00_30"), WallSpec(depth=1.0)))


def read_pressed(path: Path) -> object:
    found = read_press(path)
    return found.depth, found.force, found.displacement


def write_grid_text(path: Path) -> None:
    """A result folder of version 0.2, whose grid is a text."""
    path.mkdir()
    shutil.copy(house()["results"] / "grid.json", path)


def show_grid(path: Path) -> object:
    found = read_results(path)
    return [read_design(found, number).design.layout.positions for number in range(len(found.grid.designs))]


def play(path: Path) -> None:
    with open_source(str(path)) as source:
        for item in source.images():
            if isinstance(item, PalpateError):
                raise item


def record(path: Path, column: str = "") -> object:
    found = read_recording(path, recordings.ColumnMapping(image=column))
    for item in found.images.read(range(len(found))):
        if isinstance(item, PalpateError):
            raise item
    return found.targets


def lens(path: Path) -> object:
    found = read_calibration(path)
    return found.intrinsics_px, found.lens, found.width_px, found.height_px


def verb(words: str) -> Read:
    """A command by its words; ``{file}`` is the mutated file, other names are inputs of `house`."""
    return lambda path: main(
        [word.format(**house() | {"file": path, "folder": path.parent}) for word in words.split()]
    )


def write_timed(path: Path) -> None:
    """Table of a recording with times and a video of a variable frame rate, in a folder of this name."""
    path.mkdir()
    videos.write_pressed(path, videos.STAMPS, "time_s", [f"{stamp / 10:.3f}" for stamp in videos.STAMPS])


def write_image(path: Path) -> None:
    cv2.imwrite(str(path), IMAGES[0])


def write_library_material(path: Path) -> None:
    write_material(path, get_material("marechal_2020_ecoflex_00_30"))


def turned() -> Image.Exif:
    exif = Image.Exif()
    exif[0x0112] = 6
    return exif


PAGE = 'width="40mm" height="40mm" viewBox="0 0 40 40"'
TURNED_CIRCLES = f'<g transform="rotate(20)">{drawings.CIRCLES}</g>'
FIT = verb("material fit --tension {file} --alone --json")
RELAX = verb("material fit --files {curve} --relaxation {file} --alone --json")
SHOW = verb("design show --layout {file} --json")
PROFILE = verb("design profile --file {file} --json")
ACCEPT = verb("calibration accept --truth {file} --readings {readings} --no-zero --min-depth 0 --json")
SCORE = verb("benchmark score --predictions {file} --set {set} --json")
SET = verb("benchmark score --predictions {predictions} --set {file} --json")
DOORS: dict[str, tuple[Callable[[Path], object], Read]] = {
    **{
        f"image.{ending}": (lambda path: cv2.imwrite(str(path), IMAGES[0]), read_image)
        for ending in ("png", "jpg", "bmp")
    },
    "image.tif": (lambda path: cv2.imwrite(str(path), IMAGES[0].astype(np.uint16) * 200), read_image),
    "exif.jpg": (lambda path: Image.fromarray(IMAGES[0]).save(path, exif=turned()), read_image),
    "rest.png": (copy_of("image"), verb("calibration inspect --image {file} --markers 37 --json")),
    "boards": (write_boards, verb("calibration camera --folder {file} --board chessboard:6x5:3 --json")),
    "opencv.yaml": (text(cameras.READ["opencv_5.yaml"][0]), lens),
    "camchain.yaml": (text(cameras.READ["camchain.yaml"][0]), lens),
    "echo.yaml": (text(cameras.READ["echo_ros2.yaml"][0]), lens),
    "lens.xml": (text(cameras.READ["opencv_5.xml"][0]), lens),
    "lens.ini": (text(cameras.READ["ost.ini"][0]), lens),
    "lens.json": (text(cameras.READ["lists.json"][0]), lens),
    "cameras.txt": (text(cameras.READ["cameras.txt"][0]), lens),
    "lens.mat": (cameras.write_mat, lens),
    "poses_and_video": (write_timed, record),
    "video.mp4": (lambda path: videos.write_video(path, "libx264", list(range(6))), play),
    "video.avi": (lambda path: videos.write_video(path, "mpeg4", list(range(6))), play),
    "images.h5": (write_h5, record),
    "robomimic.hdf5": (write_robomimic, record),
    "arrays.npz": (write_npz, record),
    "arrays.zarr": (write_zarr, record),
    "toolkit": (write_toolkit, record),
    "videos": (write_videos, partial(record, column="frame")),
    "lerobot2": (partial(write_lerobot, version=2), record),
    "lerobot3": (partial(write_lerobot, version=3), record),
    "lerobot_videos": (write_lerobot_videos, record),
    "ros1.bag": (partial(write_bag, "ros1"), record),
    "mcap": (partial(write_bag, "mcap"), record),
    "sqlite": (partial(write_bag, "sqlite"), record),
    **{f"curve.{ending}": (partial(table, CURVE), FIT) for ending in ("csv", "jsonl", "parquet")},
    "relaxation.csv": (copy_of("relax"), RELAX),
    "material.yaml": (write_library_material, verb("material show --name {file} --json")),
    **{f"truth.{ending}": (partial(table, TRUTH), ACCEPT) for ending in ("csv", "jsonl", "parquet")},
    "calibration.csv": (partial(table, TRUTH), lambda path: read_ground_truth(path).poses[:, :2]),
    "readings.csv": (
        partial(table, READINGS),
        verb("calibration accept --truth {truths} --readings {file} --no-zero --min-depth 0 --json"),
    ),
    "predictions.csv": (copy_of("predictions"), SCORE),
    "set": (
        lambda path: shutil.copytree(house()["set"], path),
        verb("benchmark score --predictions {predictions} --set {file} --json"),
    ),
    "benchmark.yaml": (text(SET_SPEC), lambda path: read_benchmark_spec(str(path)).model_dump()),
    "baselines.yaml": (text("seed: 1\n"), lambda path: read_baseline_spec(str(path)).model_dump()),
    "grid": (write_grid_text, show_grid),
    "study.yaml": (text(STUDY), lambda path: read_study(path).model_dump()),
    "requirements.yaml": (copy_of("wanted"), lambda path: read_requirements(path).model_dump()),
    "results": (lambda path: shutil.copytree(house()["results"], path), verb("study show --directory {file} --json")),
    "layout.csv": (text("x_mm,y_mm\n" + "".join(f"{x:.4f},{y:.4f}\n" for x, y in drawings.SHUFFLED)), SHOW),
    "layout.dxf": (lambda path: drawings.draw(path, drawings.SHUFFLED), SHOW),
    "layout.svg": (
        lambda path: drawings.svg(path, PAGE, TURNED_CIRCLES),
        SHOW,
    ),
    "profile.csv": (copy_of("profile"), PROFILE),
    "profile.dxf": (lambda path: profiles.arcs(path, profiles.RADIUS, profiles.RADIUS + 2), PROFILE),
    "profile.step": (write_step, PROFILE),
    "twin.h5": (copy_of("twin"), read_twin),
    "press.h5": (write_pressed, read_pressed),
    "dataset.h5": (lambda path: write_dataset(path, synthetic.make_dataset(presses=20)), read_dataset),
    "unit.json": (write_identified, read_unit),
    "model.onnx": (copy_of("model"), read_pretrained),
    "model.h5": (write_recorded, read_model),
}
