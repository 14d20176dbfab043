"""Tables as labs write them: columns known by their names, and a sentence where they are wrong or mean two things."""

import json
import subprocess
import sys
from pathlib import Path

import cv2
import h5py
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from errors import check_values, refused
from needs import needs
from palpate.datasets import ColumnMapping, Recording, read_recording, read_table

COUNT = 24


def write_images(folder: Path, count: int = COUNT) -> list[str]:
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(0)
    names = [f"{number:03d}.png" for number in range(count)]
    for name in names:
        cv2.imwrite(str(folder / name), rng.integers(0, 255, (16, 16), np.uint8))
    return names


def write_csv(folder: Path, head: str, rows: list[str]) -> Path:
    path = folder / "poses.csv"
    path.write_text("\n".join([head, *rows]) + "\n")
    return path


def read(folder: Path, head: str, cells: list[list[object]], **choice: object) -> Recording:
    names = write_images(folder / "images")
    write_csv(
        folder, f"image,{head}", [",".join([name, *map(str, row)]) for name, row in zip(names, cells, strict=True)]
    )
    return read_recording(folder, ColumnMapping(**choice))  # type: ignore[arg-type]


def waves(*sizes: float) -> list[list[object]]:
    return [[round(size * np.sin(1.7 * number + k), 4) for k, size in enumerate(sizes)] for number in range(COUNT)]


def test_angles_and_depth_are_known_by_their_names_and_others_are_kept_as_motion(tmp_path: Path) -> None:
    found = read(tmp_path, "Rx_deg,Ry_deg,z_mm,shear_x_mm", waves(20, 20, 5, 4))
    assert [(one.axis, one.unit) for one in found.poses] == [("rx", "deg"), ("ry", "deg"), ("depth", "mm")]
    assert [one.axis for one in found.others] == ["shear_x"]


def test_radians_and_metres_become_degrees_and_mm(tmp_path: Path) -> None:
    found = read(tmp_path, "rx [rad],depth (m)", waves(0.4, 0.005))
    np.testing.assert_allclose(np.abs(found.targets).max(axis=0), [np.degrees(0.4), 5.0], rtol=0.05)


def test_one_angle_and_a_depth_are_a_pose(tmp_path: Path) -> None:
    found = read(tmp_path, "angle,depth", waves(30, 4))
    assert [(one.axis, one.unit) for one in found.poses] == [("angle", "deg"), ("depth", "mm")]
    assert any("angle" in note for note in found.notes)


def test_columns_to_learn_are_chosen_and_come_in_that_order(tmp_path: Path) -> None:
    found = read(tmp_path, "a_mm,b_mm,c_deg", waves(4, 4, 9), targets=("c_deg", "A_mm"))
    assert [one.column for one in found.poses] == ["c_deg", "a_mm"]


def test_columns_whose_names_do_not_tell_are_given_names_and_units(tmp_path: Path) -> None:
    found = read(tmp_path, "pose_3,pose_4,pose_5", waves(0.004, 0.4, 9), targets=("pose_4=rx_rad", "pose_3=depth_m"))
    assert [(one.axis, one.unit) for one in found.poses] == [("rx", "deg"), ("depth", "mm")]
    np.testing.assert_allclose(np.abs(found.targets).max(axis=0), [np.degrees(0.4), 4.0], rtol=0.05)


def test_columns_that_stay_or_count_or_are_text_are_left_out_and_told(tmp_path: Path) -> None:
    cells = [[1.5, number, "on", *row] for number, row in enumerate(waves(9))]
    found = read(tmp_path, "force_N,number,lamp,rx_deg", cells)
    assert [one.axis for one in found.poses] == ["rx"]
    told = " ".join(found.notes)
    check_values(told, "force_N", 1.5, "number", "lamp")


@pytest.mark.parametrize("letter", ["p", ""])
def test_images_of_one_press_are_kept_together_and_rest_is_known_by_its_press(tmp_path: Path, letter: str) -> None:
    cells = [["rest" if number < 2 else f"{letter}{number // 2}", *row] for number, row in enumerate(waves(9))]
    found = read(tmp_path, "press,rx_deg", cells)
    assert (len(found), found.presses, found.rest) == (22, 11, 2)


def test_euler_angles_become_the_rotation_vector_of_the_tilt(tmp_path: Path) -> None:
    cells = [[20.0 * np.sin(n), 0.0, 10.0 * np.cos(n)] for n in range(COUNT)]
    cells[0][1] = 1e-6
    found = read(tmp_path, "rx_deg,ry_deg,rz_deg", cells, euler="xyz", targets=("rx_deg", "ry_deg"))
    tilt = np.hypot(*found.targets.T)
    np.testing.assert_allclose(tilt, np.abs([row[0] for row in cells]), atol=1e-4)
    np.testing.assert_allclose(
        found.targets[1],
        [20 * np.sin(1) * np.cos(np.radians(10 * np.cos(1))), 20 * np.sin(1) * np.sin(np.radians(10 * np.cos(1)))],
        atol=1e-3,
    )


@pytest.mark.parametrize(
    ("head", "cells", "choice", "sentence"),
    [
        ("rx,ry_deg", waves(0.4, 9), {}, ("column-unit-unknown", "rx", "0.4")),
        ("z,rx_deg", waves(0.005, 9), {}, ("column-unit-unknown", "z", "0.005", "mm")),
        ("rx_deg", waves(9), {"targets": ("ry_deg",)}, ("column-unknown", "ry_deg", "image, rx_deg")),
        ("rx_deg", [[1.0]] * COUNT, {"targets": ("rx_deg",)}, ("column-not-trainable", "rx_deg", "1")),
        ("rx_deg", [["n/a"]] * 3 + waves(9)[3:], {"targets": ("rx_deg",)}, ("column-not-trainable", "n/a", "line 2")),
        ("rx_deg", [[""]] * 3 + waves(9)[3:], {"targets": ("rx_deg",)}, ("column-not-trainable", "3", "24")),
        ("rx_deg,rx_deg", waves(9, 9), {}, ("column-twice", "rx_deg")),
        ("lamp", [["on"]] * COUNT, {}, ("columns-none",)),
        ("press,rx_deg", [[1, *row] for row in waves(9)], {}, ("recording-few-presses", "1")),
        ("rx_deg,ry_deg", waves(9, 9), {"euler": "xxy"}, ("euler-order-unknown",)),
    ],
)
def test_what_is_wrong_with_a_table_is_told_in_a_sentence(
    tmp_path: Path, head: str, cells: list[list[object]], choice: dict[str, object], sentence: tuple[str, ...]
) -> None:
    with refused(*sentence) as caught:
        read(tmp_path, head, cells, **choice)
    assert caught.value.remedy


def test_images_that_are_nowhere_are_told_and_those_in_a_folder_below_are_found(tmp_path: Path) -> None:
    names = write_images(tmp_path / "deep" / "er")
    path = write_csv(tmp_path, "image,rx_deg", [f"{name},{n * n % 17}" for n, name in enumerate(names)])
    assert len(read_recording(path)) == COUNT
    write_csv(tmp_path, "image,rx_deg", [f"x{name},{n * n % 17}" for n, name in enumerate(names)])
    with refused("images-missing", "24", "x000.png"):
        read_recording(path)


def test_a_folder_without_a_table_or_with_two_is_refused(tmp_path: Path) -> None:
    with refused("recording-no-table"):
        read_recording(tmp_path)
    (tmp_path / "a.csv").write_text("image\n")
    (tmp_path / "b.csv").write_text("image,rx_deg\n")
    with refused("recording-several-tables", "2", "a.csv, b.csv"):
        read_recording(tmp_path)


def test_json_lines_with_nested_poses_are_read(tmp_path: Path) -> None:
    names = write_images(tmp_path)
    rows = [
        {"file": name, "pose": {"rx_deg": row[0], "xyz": row[1:]}}
        for name, row in zip(names, waves(9, 4, 4), strict=True)
    ]
    (tmp_path / "poses.jsonl").write_text("\n".join(map(json.dumps, rows)))
    found = read_recording(tmp_path, ColumnMapping(lengths="mm"))
    assert [one.column for one in found.poses] == ["pose_rx_deg", "pose_xyz_0", "pose_xyz_1"]


@pytest.mark.parametrize("groups", [1, 9])
def test_arrays_of_hdf5_are_read_and_groups_are_presses(tmp_path: Path, groups: int) -> None:
    rng = np.random.default_rng(0)
    with h5py.File(tmp_path / "recording.h5", "w") as file:
        for number in range(groups):
            place = file if groups == 1 else file.create_group(f"data/demo_{number}")
            count = 40 if groups == 1 else 5
            place["obs/image"] = rng.integers(0, 255, (count, 16, 16, 1), np.uint8)
            place["pose"] = rng.normal(size=(count, 2)) * 9
            place["pose"].attrs["columns"] = ["rx_deg", "depth_mm"]
    found = read_recording(tmp_path)
    assert [one.axis for one in found.poses] == ["rx", "depth"]
    assert (len(found), found.presses) == ((40, 40) if groups == 1 else (45, 9))
    assert next(iter(found.images.read([3]))).shape == (16, 16, 1)  # type: ignore[union-attr]


@pytest.mark.parametrize("version", ["v2.1", "v3.0"])
def test_lerobot_datasets_are_read_from_their_tables_and_videos(tmp_path: Path, version: str) -> None:
    pyarrow, parquet = needs("pyarrow"), needs("pyarrow.parquet")
    rng, camera = np.random.default_rng(0), "observation.images.tip"
    features = {
        camera: {"dtype": "video", "shape": [32, 32, 3], "names": ["height", "width", "channels"]},
        "observation.state": {"dtype": "float32", "shape": [2], "names": ["rx_deg", "depth_mm"]},
        "episode_index": {"dtype": "int64", "shape": [1], "names": None},
        "frame_index": {"dtype": "int64", "shape": [1], "names": None},
    }
    (tmp_path / "meta").mkdir()
    (tmp_path / "meta" / "info.json").write_text(
        json.dumps({"fps": 10, "codebase_version": version, "features": features})
    )

    def write_video(path: Path, levels: list[int]) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        video = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"mp4v"), 10, (32, 32))
        for level in levels:
            video.write(np.full((32, 32, 3), level, np.uint8))
        video.release()

    levels = [20 * episode + 4 * frame for episode in range(9) for frame in range(3)]
    rows = {
        "observation.state": [(rng.normal(size=2) * 9).tolist() for _ in levels],
        "episode_index": [number // 3 for number in range(27)],
        "frame_index": [number % 3 for number in range(27)],
    }
    place = tmp_path / "data" / "chunk-000" / "file-000.parquet"
    place.parent.mkdir(parents=True)
    parquet.write_table(pyarrow.table(rows), place)
    if version == "v2.1":
        for episode in range(9):
            write_video(
                tmp_path / "videos/chunk-000" / camera / f"episode_{episode:06d}.mp4", levels[3 * episode :][:3]
            )
    else:
        write_video(tmp_path / "videos" / camera / "chunk-000" / "file-000.mp4", levels)
        about = {
            "episode_index": list(range(9)),
            f"videos/{camera}/chunk_index": [0] * 9,
            f"videos/{camera}/file_index": [0] * 9,
            f"videos/{camera}/from_timestamp": [0.3 * episode for episode in range(9)],
        }
        (tmp_path / "meta/episodes/chunk-000").mkdir(parents=True)
        parquet.write_table(pyarrow.table(about), tmp_path / "meta/episodes/chunk-000/file-000.parquet")
    found = read_recording(tmp_path)
    assert (len(found), found.presses, [one.axis for one in found.poses]) == (27, 9, ["rx", "depth"])
    images = list(found.images.read([0, 4, 13]))
    for image, number in zip(images, (0, 4, 13), strict=True):
        assert abs(float(np.mean(image)) - levels[number]) < 6  # type: ignore[arg-type]


def write_long_table(folder: Path, rows: int) -> Path:
    names = write_images(folder, 25)
    with (folder / "poses.csv").open("w") as file:
        file.write("image,press,rx_deg,depth_mm\n")
        file.writelines(f"{names[n % 25]},{n // 100},{n % 97}.5,{n % 7}\n" for n in range(rows))
    return folder


def test_a_long_table_is_thinned_by_whole_presses_and_that_is_told(tmp_path: Path) -> None:
    found = read_recording(write_long_table(tmp_path, 50_000), most=2000)
    assert (len(found), found.presses) == (2000, 20)
    assert any("50000" in note and "2000" in note for note in found.notes)


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="no /proc tells the peak of a process")
def test_a_table_of_a_million_rows_is_read_in_bounded_memory(tmp_path: Path) -> None:
    code = (  # not ru_maxrss, which a child inherits from the process that started it
        "import re, sys; from pathlib import Path; from palpate.datasets import read_recording;"
        "print(len(read_recording(Path(sys.argv[1]), most=2000)),"
        " re.search(r'VmHWM:\\s+(\\d+)', Path('/proc/self/status').read_text())[1])"
    )
    place = write_long_table(tmp_path, 1_000_000)
    shown = subprocess.run([sys.executable, "-c", code, str(place)], check=True, capture_output=True, text=True)
    count, most_kib = map(int, shown.stdout.split())
    assert count == 2000
    assert most_kib < 500_000


def test_a_table_that_is_none_is_refused_in_a_sentence(tmp_path: Path) -> None:
    for name, content, sentence in (
        ("a.csv", b"\xff\xfe\x00garbage\x80\x81" * 20, ("table-no-numbers",)),
        ("b.csv", b"image,rx\n", ("table-empty",)),
        ("c.csv", b"1.0,2.0,3.0\n1,2,3\n", ("header-missing",)),
        ("d.csv", b"image,rx\n1.png,2,3,4\n", ("header-length-wrong",)),
        ("e.jsonl", b"[1, 2]\n", ("table-line-not-object",)),
    ):
        (tmp_path / name).write_bytes(content)
        with refused(*sentence):
            read_table(tmp_path / name)


@pytest.mark.parametrize("head", ["rx,ry,depth_mm", "euler_x,euler_y,depth_mm", "rot_x,rot_y,depth_mm"])
@pytest.mark.parametrize("turn", [0.0, np.pi])
@pytest.mark.parametrize("circle", [False, True], ids=["-π to π", "0 to 2π"])
def test_radians_without_a_unit_are_never_taken_as_degrees(
    tmp_path: Path, head: str, turn: float, circle: bool
) -> None:
    """Tilts of 0.4 rad of a tool that points up (0) or down (π), in both ways of writing angles."""
    angles = np.array([[row[0] + turn, row[1]] for row in waves(0.4, 0.4)], float)
    angles = angles % (2 * np.pi) if circle else (angles + np.pi) % (2 * np.pi) - np.pi
    cells = [[*row, 2 + 0.1 * number] for number, row in enumerate(angles.round(5).tolist())]
    with refused("column-unit-unknown", "radians or degrees", "--angles deg", "--angles rad"):
        read(tmp_path, head, cells)
    if turn:
        with refused(
            "orientation-unknown" if not circle else ("orientation-unknown", "orientation-spread"), "--orientation"
        ):
            read(tmp_path, head, cells, angles="rad")
        found = read(tmp_path, head, cells, angles="rad", euler="xyz")
    else:
        found = read(tmp_path, head, cells, angles="rad", **({"euler": "xyz"} if circle else {}))
    assert np.abs(found.targets[:, :2]).max() == pytest.approx(np.degrees(0.4), abs=2.0)


@pytest.mark.parametrize(("size", "shift"), [(6, 0), (20, -10)])
def test_degrees_without_a_unit_are_read_as_such(tmp_path: Path, size: int, shift: int) -> None:
    """Tilts from 0 to 6°, whose values would fit a circle of radians, and of both signs."""
    cells = [[k % (size + 1) + shift, (3 * k) % (size + 1) + shift, 2 + 0.1 * k] for k in range(COUNT)]
    found = read(tmp_path, "rx,ry,depth_mm", cells)
    assert found.targets[:, :2] == pytest.approx(np.array(cells)[:, :2])


@pytest.mark.parametrize("delimiter", [";", ",", "\t"])
def test_the_pose_of_a_ur_robot_in_one_cell_is_read(tmp_path: Path, delimiter: str) -> None:
    """The tool points down; its tilt and depth follow from the rotation vector in the cell."""
    rng, down = np.random.default_rng(1), Rotation.from_euler("x", 180, degrees=True)
    names, poses = (
        write_images(tmp_path / "images"),
        np.column_stack([rng.uniform(-8, 8, (COUNT, 2)), np.zeros(COUNT)]),
    )
    cells = []
    for number, turn in enumerate((Rotation.from_rotvec(poses, degrees=True) * down).as_rotvec()):
        place = [0.4, -0.1, 0.2 - 1e-4 * number]
        cells.append("p[" + ", ".join(f"{value:.6f}" for value in [*place, *turn]) + "]")
    rows = [delimiter.join([name, cell]) for name, cell in zip(names, cells, strict=True)]
    write_csv(tmp_path, delimiter.join(["image", "pose"]), rows)
    found = read_recording(tmp_path)
    tilt = np.hypot(*(found.targets[:, :2] - found.targets[:, :2].mean(axis=0)).T)
    assert tilt == pytest.approx(np.hypot(*(poses[:, :2] - poses[:, :2].mean(axis=0)).T), abs=0.3)
    assert np.ptp(found.targets[:, 2]) == pytest.approx(2.3, rel=0.02)
