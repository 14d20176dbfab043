"""Where the images of a recording lie, and which recordings are too small or doubtful: each limit from both sides."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from errors import refused
from palpate.datasets import ColumnMapping, read_recording
from palpate.datasets.stored_images import holds_images, join_parts, merge_columns, name_columns, read_row


def write(folder: Path, head: str, rows: list[str], images: list[str]) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "poses.csv").write_text("\n".join([head, *rows]) + "\n")
    for number, name in enumerate(images):
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        cv2.imwrite(str(path), np.full((16, 16), number, np.uint8))
    return folder


def cells(count: int) -> list[str]:
    return [f"{20 * np.sin(k):.3f},{3 + np.cos(k):.3f}" for k in range(count)]


@pytest.mark.parametrize("count", [7, 8])
def test_a_recording_has_eight_images_or_more(count: int, tmp_path: Path) -> None:
    names = [f"{k}.png" for k in range(count)]
    rows = [f"{name},{cell}" for name, cell in zip(names, cells(count), strict=True)]
    write(tmp_path, "image,rx_deg,depth_mm", rows, names)
    if count < 8:
        with refused("recording-few-images", 7, 8):
            read_recording(tmp_path)
    else:
        found = read_recording(tmp_path)
        assert (len(found), found.presses, found.rest) == (8, 8, 0)


@pytest.mark.parametrize(("last", "code"), [("8.5", "image-number-wrong"), ("30", "recording-several-videos")])
def test_images_are_numbered_by_whole_numbers_that_exist(last: str, code: str, tmp_path: Path) -> None:
    names = [f"shot_{k}.png" for k in range(9)]
    numbers = [*map(str, range(8)), last]
    rows = [f"{number},{cell}" for number, cell in zip(numbers, cells(9), strict=True)]
    write(tmp_path, "image,rx_deg,depth_mm", rows, names)
    with refused(code, last):
        read_recording(tmp_path)
    rows[-1] = f"8,{cells(9)[-1]}"
    write(tmp_path, "image,rx_deg,depth_mm", rows, names)
    found = read_recording(tmp_path)
    assert [int(image.flat[0]) for image in found.images.read(range(9))] == list(range(9))


def test_whole_presses_are_drawn_if_there_are_too_many_images(tmp_path: Path) -> None:
    names = [f"{k}.png" for k in range(30)]
    rows = [f"{name},{k // 2},{cell}" for k, (name, cell) in enumerate(zip(names, cells(30), strict=True))]
    write(tmp_path, "image,press,rx_deg,depth_mm", rows, names)
    found = read_recording(tmp_path, most=21, seed=3)
    numbers = sorted(int(Path(name).stem) for name in found.names)
    assert len(numbers) == 20
    assert numbers[1::2] == [number + 1 for number in numbers[::2]]
    assert found.press.tolist() == np.repeat(np.arange(10), 2).tolist()
    assert read_recording(tmp_path, most=30).names == tuple(names)
    assert read_recording(tmp_path, most=21, seed=4).names != found.names


def test_a_topic_needs_a_bag_and_a_missing_place_is_named(tmp_path: Path) -> None:
    write(
        tmp_path,
        "image,rx_deg,depth_mm",
        [f"{k}.png,{c}" for k, c in enumerate(cells(8))],
        [f"{k}.png" for k in range(8)],
    )
    with refused("flag-not-used", "/pose"):
        read_recording(tmp_path, ColumnMapping(pose="/pose"))
    with refused("file-missing", "none"):
        read_recording(tmp_path / "none")


def test_values_of_an_image_must_be_numbers() -> None:
    levels = np.linspace(0, 1, 3 * 8 * 10).reshape(3, 8, 10)
    assert holds_images(levels)
    assert read_row(levels, 2).tolist() == levels[2].tolist()
    levels[1, 2, 3] = np.nan
    with refused("image-not-finite", 1):
        read_row(levels, 1)


def test_columns_of_arrays_have_their_names_units_and_paths() -> None:
    pair = np.arange(6.0).reshape(3, 2)
    assert list(name_columns("pose", pair, {})) == ["pose_0", "pose_1"]
    named = name_columns("pose", pair, {"columns": [b"rx", b"depth"], "units": "deg, mm"})
    assert {name: values.tolist() for name, values in named.items()} == {
        "rx [deg]": [0, 2, 4],
        "depth [mm]": [1, 3, 5],
    }
    assert list(name_columns("pose", pair, {"names": "rx_deg,depth", "unit": "mm"})) == ["rx_deg", "depth [mm]"]
    assert list(name_columns("depth", pair[:, 0], {"unit": "mm"})) == ["depth [mm]"]
    assert list(name_columns("pose", pair, {"columns": ["rx"]})) == ["pose_0", "pose_1"]
    merged = merge_columns([(["a", "z"], pair[:, 0], {}), (["b", "z"], pair[:, 1], {}), (["b", "x"], pair[:, 1], {})])
    assert {name: values.tolist() for name, values in merged.items()} == {
        "a_z": [0, 2, 4],
        "b_z": [1, 3, 5],
        "x": [1, 3, 5],
    }


def test_parts_share_columns_beside_the_press() -> None:
    one, other = ({"press": np.array([k]), "z": np.array([k + 0.5]), f"only_{k}": np.array([k])} for k in (0, 1))
    assert {name: values.tolist() for name, values in join_parts("f", [one, other]).items()} == {
        "press": [0, 1],
        "z": [0.5, 1.5],
    }
    for part in (one, other):
        part.pop("z")
    with refused("recording-no-table", "f"):
        join_parts("f", [one, other])
