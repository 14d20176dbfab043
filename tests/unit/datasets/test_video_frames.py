"""Rows of a table and the images of videos, drawn so that each image tells its number."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from errors import refused
from palpate.datasets import ColumnMapping, RecordingTable
from palpate.datasets.video_frames import list_videos, number_frames, videos_of_rows

PLAIN = ColumnMapping()
RATE = 10.0


def draw_video(path: Path, count: int = 6) -> Path:
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), RATE, (32, 32))
    for number in range(count):
        writer.write(np.full((32, 32, 3), 20 * number, np.uint8))
    writer.release()
    return path


def table(count: int = 6, **columns: object) -> RecordingTable:
    given = {"rx_deg": np.arange(float(count)), **columns}
    return RecordingTable("t.csv", {name: np.asarray(values) for name, values in given.items()}, {})


def frames(folder: Path, rows: RecordingTable) -> list[float]:
    return number_frames(rows, folder, PLAIN).columns["frame"].tolist()


def test_videos_come_in_natural_order_without_hidden_files(tmp_path: Path) -> None:
    for name in ("b10.avi", "b9.avi", ".c.avi", "notes.txt"):
        (tmp_path / name).write_bytes(b"")
    assert [path.name for path in list_videos(tmp_path)] == ["b9.avi", "b10.avi"]


def test_a_column_of_file_names_tells_the_video_of_a_row() -> None:
    videos = [Path("a.avi"), Path("b.avi")]
    assert videos_of_rows(table(3, video=["x/b.avi", "a.avi", "x\\b.avi"]), videos) == [1, 0, 1]
    assert videos_of_rows(table(3, video=["b.avi", "c.avi", "a.avi"]), videos) is None
    assert videos_of_rows(table(3), videos) is None
    assert videos_of_rows(table(3), videos[:1]) == [0, 0, 0]
    assert videos_of_rows(table(3), []) is None


@pytest.mark.parametrize(
    ("counted", "wanted"), [((0, 2, 5), (0, 2, 5)), ((1, 3, 6), (0, 2, 5)), ((1, 3, 5), (1, 3, 5))]
)
def test_a_counter_counts_from_one_only_if_it_ends_at_the_last_image(
    counted: tuple[int, ...], wanted: tuple[int, ...], tmp_path: Path
) -> None:
    draw_video(tmp_path / "a.avi")
    found = number_frames(table(3, frame_no=np.array(counted, float)), tmp_path, PLAIN)
    assert found.columns["frame"].tolist() == list(wanted)
    assert "frame_no" not in found.columns
    assert any("from 1" in note for note in found.notes) == (counted != wanted)


def test_rows_are_taken_in_order_if_there_is_one_for_each_image(tmp_path: Path) -> None:
    draw_video(tmp_path / "a.avi")
    assert frames(tmp_path, table()) == [0, 1, 2, 3, 4, 5]
    with refused("image-column-missing", "a.avi", 6, 5):
        number_frames(table(5), tmp_path, PLAIN)


def test_a_time_finds_the_nearest_image_and_an_image_its_nearest_row(tmp_path: Path) -> None:
    draw_video(tmp_path / "a.avi")
    time = np.array([0.0, 0.04, 0.12, 0.28, 0.31, 0.44, 0.59, 0.61])
    found = number_frames(table(8, time_s=time), tmp_path, PLAIN)
    assert found.columns["frame"].tolist() == [0, 1, 3, 4, 5]
    assert found.columns["rx_deg"].tolist() == [0, 2, 4, 5, 6]
    assert any("3 of 8" in note for note in found.notes)


@pytest.mark.parametrize(("outside", "read"), [(2, True), (3, False)])
def test_times_must_overlap_for_half_of_the_rows(outside: int, read: bool, tmp_path: Path) -> None:
    draw_video(tmp_path / "a.avi")
    time = np.concatenate([[0.0, 0.2], 5.0 + np.arange(outside)])
    if read:
        assert frames(tmp_path, table(2 + outside, time_s=time)) == [0, 2]
    else:
        with refused("times-no-overlap", "a.avi"):
            number_frames(table(2 + outside, time_s=time), tmp_path, PLAIN)


def test_a_time_without_a_unit_is_not_taken_for_the_order(tmp_path: Path) -> None:
    draw_video(tmp_path / "a.avi")
    with refused("time-unit-unknown"):
        number_frames(table(time=3.0 * np.arange(6)), tmp_path, PLAIN)


def test_a_table_that_names_images_or_lies_beside_images_is_left_as_it_is(tmp_path: Path) -> None:
    draw_video(tmp_path / "a.avi")
    rows = table()
    assert number_frames(rows, tmp_path, ColumnMapping(image="rx_deg")) is rows
    cv2.imwrite(str(tmp_path / "rest.png"), np.zeros((16, 16), np.uint8))
    assert frames(tmp_path, rows) == [0, 1, 2, 3, 4, 5]
    cv2.imwrite(str(tmp_path / "a.png"), np.zeros((16, 16), np.uint8))
    assert number_frames(rows, tmp_path, PLAIN) is rows


def test_each_video_counts_its_own_images(tmp_path: Path) -> None:
    for name, count in (("a.avi", 3), ("b.avi", 4)):
        draw_video(tmp_path / name, count)
    video = np.array(["b.avi", "a.avi", "b.avi", "a.avi", "b.avi", "a.avi", "b.avi"])
    assert frames(tmp_path, table(7, video=video)) == [0, 0, 1, 1, 2, 2, 3]


def test_a_damaged_video_is_refused(tmp_path: Path) -> None:
    path = draw_video(tmp_path / "a.avi")
    data = bytearray(path.read_bytes())
    at = [at for at in range(len(data) - 1) if data[at : at + 2] == b"\xff\xd8"][3]
    data[at : at + 300] = bytes(300)
    path.write_bytes(bytes(data))
    with refused("video-cut-off", "a.avi", 3, 6):
        number_frames(table(3), tmp_path, PLAIN)
