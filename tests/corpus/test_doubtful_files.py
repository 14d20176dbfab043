"""Files that a wider reader could read wrongly: names like numbers, groups of several things, other numbers."""

import json
from pathlib import Path

import cv2
import h5py
import numpy as np
import pytest

from errors import refused
from palpate.camera import read_calibration
from palpate.core.tables import read_table
from palpate.datasets import Recording, read_recording
from palpate.material import TestFileSpec as FileSpec
from palpate.material import read_test_file

COUNT = 24
RANDOM = np.random.default_rng(12)
POSES = np.column_stack([RANDOM.uniform(-9, 9, (COUNT, 2)), RANDOM.uniform(0.5, 4, COUNT)]).round(4)
NAMES = ("rx_deg", "ry_deg", "depth_mm")
MATRIX = [[500, 0, 320], [0, 500, 240], [0, 0, 1]]
FOCAL = {"fx": 500, "fy": 500, "cx": 320, "cy": 240}
SIZE = {"width": 640, "height": 480}

TABLES: dict[str, tuple[str, tuple[str, ...], list[object]]] = {
    "names that end with a letter": ("press,x\n0A,1\n0A,2\n1A,3\n", ("press", "x"), ["0A", 1.0]),
    "names with a letter between digits": ("sample,x\n1D2,1\n10D1,2\n", ("sample", "x"), ["1D2", 1.0]),
    "decimal commas between spaces": (
        "a b\n" + "".join(f"{k},5 {100 + k},5\n" for k in range(1, 9)),
        ("a", "b"),
        [1.5, 101.5],
    ),
    "pairs of numbers": ("a;b\n101 201;1,5\n102 202;2,5\n", ("a", "b"), ["101 201", 1.5]),
    "addresses": ("a;b\n192.168.100.101;1,5\n192.168.100.102;2,5\n", ("a", "b"), ["192.168.100.101", 1.5]),
    "a header of quantities": ("10 mm,20 mm\n1,2\n3,4\n", ("10 mm", "20 mm"), [1.0, 2.0]),
    "a title in a comment": ("# Stress strain\n1,2\n3,4\n5,6\n", ("", ""), [1.0, 2.0]),
    "a remark below the heading": ("# a,b\n# Tensile test\n1,2\n3,4\n# test finished\n", ("a", "b"), [1.0, 2.0]),
    "units with spaces": ("a,b\n1.5 %,2.25 MPa\n2.5 %,2.5 MPa\n", ("a", "b"), [1.5, 2.25]),
    "units of some columns": ("a,b\n1.5 %,2.25\n2.5 %,2.5\n", ("a", "b"), [1.5, 2.25]),
    "a list that has a name": ('a_0,a\n1,"[5, 6]"\n2,"[7, 8]"\n', ("a_0", "a"), [1.0, "[5, 6]"]),
    "first rows with one cell": ("a,b,c\nrest,,\nrest,,\n1,2,3\n4,5,6\n", ("a", "b", "c"), ["rest", np.nan, np.nan]),
    "a first row with one cell": ("a,b,c\nrest,,\n1,2,3\n4,5,6\n", ("a", "b", "c"), ["rest", np.nan, np.nan]),
}


@pytest.mark.parametrize("name", TABLES)
def test_a_doubtful_table_keeps_its_names_and_cells(name: str, tmp_path: Path) -> None:
    text, header, first = TABLES[name]
    (tmp_path / "t.csv").write_text(text)
    found = read_table(tmp_path / "t.csv", words=("rest",))
    assert found.header == header
    for column, right in zip(found.columns, first, strict=True):
        assert column[0] == right or (right != right and not np.isfinite(column[0]))


def test_a_unit_that_changes_far_below_is_a_fault(tmp_path: Path) -> None:
    rows = [f"{k} mm,{k}" for k in range(20_001)]
    (tmp_path / "t.csv").write_text("\n".join(["a,b", *rows, "5 in,3", ",4", "7 mm,1", ""]))
    found = read_table(tmp_path / "t.csv")
    assert found.unit(0) == "mm"
    assert found.faults[0].text == "5 in"
    assert found.columns[0][-1] == 7.0


@pytest.mark.parametrize(
    "head",
    [
        "Stretch,Pressure (kPa)",
        "Lateral strain (%),Stress (MPa)",
        "Strain,Modulus (MPa)",
        "Humidity (%),Stress (MPa)",
        "Width (mm),Force (N)",
    ],
)
def test_another_quantity_is_not_taken_for_its_unit(head: str, tmp_path: Path) -> None:
    path = tmp_path / "tension.csv"
    path.write_text("\n".join([head, *(f"{1 + k / 20},{k}" for k in range(20)), ""]))
    with refused("column-missing"):
        read_test_file(path, FileSpec(gauge_length=10, section=10))


CAMERAS: dict[str, tuple[dict[str, object], str]] = {
    "a second lens": (
        {"mtx": MATRIX, "dist": [0] * 5, "image_size": [640, 480], "depth": {"fx": 900, "fy": 901, "cx": 6, "cy": 3}},
        "Brown",
    ),
    "a pinhole of OpenCV": (FOCAL | SIZE | {"model": "opencv", "k1": -0.3, "k2": 0.1, "k3": 0, "k4": 0}, "Brown"),
    "a rational model": (
        FOCAL | SIZE | {"model": "rational"} | {f"k{n}": 0.01 * n for n in range(1, 7)},
        "Rational",
    ),
    "a fisheye of nerfstudio": (
        FOCAL
        | SIZE
        | {"camera_model": "OPENCV_FISHEYE", "k1": 0.1, "k2": 0.01, "k3": 0.1, "k4": 0.1, "p1": 0, "p2": 0},
        "KannalaBrandt",
    ),
    "a camera's type": (
        {"camera_matrix": MATRIX, "dist": [0] * 5, "sensor": {"model": "X"}, "camera_model": "Y"} | SIZE,
        "Brown",
    ),
    "two lenses": ({"colour": FOCAL, "depth": FOCAL} | SIZE, "calibration-several-cameras"),
    "the size of a board": (FOCAL | {"board": {"width": 9, "height": 6}}, "calibration-file-unreadable"),
    "a centre outside": (FOCAL | {"width": 300, "height": 200, "dist": [0] * 5}, "calibration-file-unreadable"),
    "four of which lens": (
        {"camera_matrix": MATRIX, "model": "pinhole", "dist": [0.05, 0.02, -0.03, 0.015]} | SIZE,
        "lens-coefficient-count",
    ),
}


@pytest.mark.parametrize("name", CAMERAS)
def test_a_doubtful_camera_file_is_read_rightly_or_refused(name: str, tmp_path: Path) -> None:
    content, right = CAMERAS[name]
    (tmp_path / "c.json").write_text(json.dumps(content))
    if "-" in right:
        with refused(right):
            read_calibration(tmp_path / "c.json")
        return
    found = read_calibration(tmp_path / "c.json")
    assert type(found.lens).__name__ == right
    assert found.intrinsics_px.tolist() == [500, 500, 320, 240]
    assert (found.width_px, found.height_px) == (640, 480)


def write_images(folder: Path, form: str = "img_{:03d}.png") -> None:
    for number in range(COUNT):
        cv2.imwrite(str(folder / form.format(number)), np.full((8, 8), number, np.uint8))


def write_table(folder: Path, head: str, first: list[list[object]], rows: np.ndarray = POSES) -> Path:
    lines = [",".join(map(str, [*cells, *row])) for cells, row in zip(first, rows.tolist(), strict=True)]
    (folder / "p.csv").write_text("\n".join([f"{head},rx_deg,ry_deg,depth_mm", *lines, ""]))
    return folder / "p.csv"


def brightness(found: Recording) -> list[int]:
    return [int(np.asarray(image).mean()) for image in found.images.read(range(len(found)))]


@pytest.mark.parametrize("head", ["sample", "image,file"])
def test_names_without_endings_in_any_column_find_their_images(head: str, tmp_path: Path) -> None:
    write_images(tmp_path)
    order = RANDOM.permutation(COUNT).tolist()
    first: list[list[object]] = [[f"img_{k:03d}", *["x"] * head.count(",")] for k in order]
    assert brightness(read_recording(write_table(tmp_path, head, first))) == order


@pytest.mark.parametrize(
    ("head", "first", "code"),
    [
        ("id", [[k] for k in RANDOM.permutation(COUNT).tolist()], "image-column-missing"),
        ("frame", [[0.9 * k] for k in range(COUNT)], "image-number-wrong"),
    ],
)
def test_numbers_that_are_no_order_of_images_are_refused(
    head: str, first: list[list[object]], code: str, tmp_path: Path
) -> None:
    write_images(tmp_path)
    with refused(code):
        read_recording(write_table(tmp_path, head, first))


def test_presses_called_by_a_letter_stay_together(tmp_path: Path) -> None:
    write_images(tmp_path)
    path = write_table(tmp_path, "image,press", [[f"img_{k:03d}.png", f"{k // 2}A"] for k in range(COUNT)])
    assert read_recording(path).presses == COUNT // 2


def test_gaps_of_other_columns_cost_no_row(tmp_path: Path) -> None:
    write_images(tmp_path)
    spare = [["" if k // 2 == n else 1.5 * k for n in range(12)] for k in range(COUNT)]
    head = "image," + ",".join(f"z_{n}_mm" for n in range(12))
    path = write_table(tmp_path, head, [[f"img_{k:03d}.png", *spare[k]] for k in range(COUNT)])
    assert len(read_recording(path)) == COUNT


def test_a_file_about_the_recording_is_not_its_table(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["images"] = np.zeros((COUNT, 16, 16), np.uint8)
        file["masks"] = np.ones((COUNT, 16, 16), bool)
        for at, name in enumerate(NAMES):
            file[name] = POSES[:, at]
    (tmp_path / "metadata.json").write_text('{"sensor": "A"}')
    assert read_recording(tmp_path).targets == pytest.approx(POSES)


def test_a_readme_is_not_the_table_of_a_recording(tmp_path: Path) -> None:
    write_images(tmp_path)
    write_table(tmp_path, "image", [[f"img_{k:03d}.png"] for k in range(COUNT)])
    (tmp_path / "README.txt").write_text("Presses of May, by hand, 24 images")
    assert len(read_recording(tmp_path)) == COUNT


@pytest.mark.parametrize("head", ["timestamp_s", "press"])
def test_a_damaged_video_beside_a_table_is_named(head: str, tmp_path: Path) -> None:
    (tmp_path / "gel.mp4").touch()
    (tmp_path / "._gel.mp4").touch()
    path = write_table(tmp_path, head, [[k / 30] for k in range(COUNT)])
    with refused("source-not-opened", "gel.mp4") as caught:
        read_recording(path)
    assert "._gel" not in caught.value.problem


def test_equal_names_of_two_arrays_get_the_names_of_the_arrays(tmp_path: Path) -> None:
    fields = [("x_mm", float), ("rx_deg", float), ("ry_deg", float)]
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["images"] = np.zeros((COUNT, 16, 16), np.uint8)
        for name, factor in (("pose", 1.0), ("target", 2.0)):
            file[name] = np.array([tuple(factor * row) for row in POSES], dtype=fields)
    found = read_recording(tmp_path / "a.h5")
    assert {one.column for one in (*found.poses, *found.others)} == {
        f"{array}_{name}" for array in ("pose", "target") for name, _ in fields
    }


def test_a_unit_of_an_attribute_does_not_replace_that_of_a_name(tmp_path: Path) -> None:
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["images"] = np.zeros((COUNT, 16, 16), np.uint8)
        file["poses"] = POSES
        file["poses"].attrs["columns"] = "rx_deg,ry_deg,depth"
        file["poses"].attrs["units"] = "mm"
    assert read_recording(tmp_path / "a.h5").targets == pytest.approx(POSES)


@pytest.mark.parametrize(
    "value",
    [
        {"strain": {str(k): k for k in range(5)}, "stress": {str(k): 2 * k for k in range(5)}},
        {"strain": list(range(5)), "stress": [2 * k for k in range(5)]},
    ],
)
def test_columns_of_json_are_columns(value: dict[str, object], tmp_path: Path) -> None:
    (tmp_path / "t.json").write_text(json.dumps(value))
    found = read_table(tmp_path / "t.json")
    assert found.header == ("strain", "stress")
    assert found.columns[1].tolist() == [0, 2, 4, 6, 8]
