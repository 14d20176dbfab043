"""Everyday files are read to the right numbers, or refused for the true cause; none is read wrongly."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from table_corpus import Case, material_cases, pose_cases

from errors import refused
from palpate.core import PalpateError
from palpate.datasets import ColumnMapping, read_recording, read_table
from palpate.material import TestFileSpec as FileSpec
from palpate.material import read_test_file
from palpate.sensor import read_ground_truth

MATERIAL = {case.name: case for case in material_cases()}
POSES = {case.name: case for case in pose_cases()}


def write(folder: Path, case: Case) -> Path:
    path = folder / case.file.replace("tension.csv", "tension.csv" if case.name in MATERIAL else "poses.csv")
    path.write_bytes(case.data)
    return path


def test_the_corpus_is_large() -> None:
    assert len(MATERIAL) + len(POSES) >= 80
    assert sum(bool(case.code) for case in (*MATERIAL.values(), *POSES.values())) >= 15


@pytest.mark.parametrize("name", MATERIAL)
def test_a_test_file_is_read_or_refused(name: str, tmp_path: Path) -> None:
    case = MATERIAL[name]
    path = write(tmp_path, case)
    if case.code:
        with refused(case.code):
            read_test_file(path, FileSpec(**case.flags))
        return
    samples = read_test_file(path, FileSpec(**case.flags))
    assert len(samples) == len(case.right)
    for sample, (stretch, nominal) in zip(samples, case.right, strict=True):
        assert sample.stretch == pytest.approx(stretch, abs=1e-6)
        assert sample.nominal == pytest.approx(nominal, rel=1e-5, abs=1e-8)


@pytest.fixture(scope="module")
def images(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("images")
    for number in range(24):
        cv2.imwrite(str(folder / f"img_{number:03d}.png"), np.full((8, 8), 9 * number, np.uint8))
    return folder


@pytest.mark.parametrize("name", POSES)
def test_poses_are_read_or_refused(name: str, images: Path) -> None:
    case = POSES[name]
    path = write(images, case)
    try:
        if case.code:
            with refused(case.code):
                read_recording(path, ColumnMapping(**case.flags))
            return
        found = read_recording(path, ColumnMapping(**case.flags))
        assert [one.axis for one in found.poses] == ["rx", "ry", "depth"]
        wrong = found.targets - case.right[0]
        if "depth_mm" not in (one.column for one in found.others) and any("shallowest" in n for n in found.notes):
            wrong[:, 2] -= np.median(wrong[:, 2])
        assert np.abs(wrong).max() < 2e-4
    finally:
        path.unlink()


@pytest.mark.parametrize(
    "name",
    [name for name, case in POSES.items() if case.right and case.file == "tension.csv" and "no images" not in name],
)
def test_a_truth_is_read_by_the_same_names(name: str, tmp_path: Path) -> None:
    case = POSES[name]
    encoding = next((e for e in ("utf-16", "utf-8-sig", "cp1252") if e in name), "utf-8")
    lines = case.data.decode(encoding).splitlines()
    sep = next(mark for mark in ("\t", ";", "|", ",", " ") if mark in lines[0])
    units = lines[1].startswith(sep)
    cells = [("press", *([""] if units else []))[k] if k <= units else str(k) for k in range(len(lines))]
    path = tmp_path / "truth.csv"
    path.write_text(
        "\n".join(f"{line}{sep}{cell}" for line, cell in zip(lines, cells, strict=True)), encoding=encoding
    )
    found = read_ground_truth(path, ColumnMapping(**case.flags))
    assert np.abs(found.poses[:, :2] - case.right[0][:, :2]).max() < 2e-4


def test_mutated_tables_give_a_result_or_a_sentence(images: Path, tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    cases = [*MATERIAL.values(), *POSES.values()]
    counts, sentences = {True: 0, False: 0}, []
    for _ in range(150):
        case = cases[rng.integers(len(cases))]
        folder = tmp_path if case.name in MATERIAL else images
        path = write(folder, Case(case.name, mutate(case.data, rng), file=case.file))
        try:
            if case.name in MATERIAL:
                read_test_file(path, FileSpec(**case.flags))
            else:
                read_recording(path, ColumnMapping(**case.flags))
            counts[True] += 1
        except PalpateError as error:
            sentences.append((error.problem, error.remedy))
            counts[False] += 1
        path.unlink()
    assert min(counts.values()) > 20
    assert all(problem and remedy for problem, remedy in sentences)


def mutate(data: bytes, rng: np.random.Generator) -> bytes:
    """Bytes inserted, deleted and changed, lines doubled, swapped and cut."""
    changed = bytearray(data)
    for _ in range(rng.integers(1, 5)):
        at = int(rng.integers(len(changed) + 1))
        match rng.integers(5):
            case 0:
                scraps = (b",", b";", b"\t", b"\n", b'"', b"nan", b"1e400", b"-", b"\x00", b"\xff", b"abc", b"(Pa)")
                changed[at:at] = scraps[rng.integers(len(scraps))]
            case 1:
                del changed[at : at + int(rng.integers(1, 40))]
            case 2:
                changed[at : at + 1] = bytes([int(rng.integers(256))])
            case 3:
                lines = bytes(changed).split(b"\n")
                lines.insert(int(rng.integers(len(lines))), lines[rng.integers(len(lines))])
                changed = bytearray(b"\n".join(lines))
            case _:
                lines = bytes(changed).split(b"\n")
                del lines[int(rng.integers(len(lines)))]
                changed = bytearray(b"\n".join(lines))
    return bytes(changed)


def test_a_long_table_keeps_its_texts(tmp_path: Path) -> None:
    rows = "".join(f"{k:05d}.png,{k % 7}.5\n" for k in range(45_000))
    (tmp_path / "long.csv").write_text("image,rx_deg\n" + rows)
    found = read_table(tmp_path / "long.csv")
    assert found.columns["image"][[0, 19_999, 20_000, 44_999]].tolist() == [
        "00000.png",
        "19999.png",
        "20000.png",
        "44999.png",
    ]
    assert np.isfinite(found.columns["rx_deg"]).all()


def test_rows_without_a_number_of_the_pose_are_left_out_and_counted(images: Path) -> None:
    case = POSES["plain poses"]
    lines = case.data.decode().splitlines()
    lines[4] = lines[4].rsplit(",", 1)[0] + ","
    path = write(images, Case("plain poses", "\n".join(lines).encode()))
    found = read_recording(path)
    assert np.abs(found.targets - np.delete(case.right[0], 3, axis=0)).max() < 1e-9
    assert found.names == tuple(f"img_{k:03d}.png" for k in range(24) if k != 3)
    assert any("1 of 24" in note and "depth_mm" in note for note in found.notes)
    path.write_text(
        "\n".join([lines[0], *(line.rsplit(",", 1)[0] + "," if k % 4 else line for k, line in enumerate(lines[1:]))])
    )
    assert [one.axis for one in read_recording(path).poses] == ["rx", "ry"]
    path.unlink()


def test_images_of_a_truth_are_found_below_its_folder(tmp_path: Path) -> None:
    (tmp_path / "recording" / "images").mkdir(parents=True)
    names = ["rest.png", "one.png", "two.png"]
    for name in names:
        cv2.imwrite(str(tmp_path / "recording" / "images" / name), np.zeros((4, 4), np.uint8))
    path = tmp_path / "truth.csv"
    path.write_text("image;press;rx_deg;ry_deg;depth_mm\nrest.png;rest;;;\none.png;1;1,5;0;2\ntwo.png;1;2,5;0;2\n")
    found = read_ground_truth(path).locate(tmp_path)
    assert [Path(name).parent.name for name in (*found.rest, *found.images)] == ["images"] * 3
    assert [Path(name).name for name in (*found.rest, *found.images)] == names
    with refused("images-missing", "rest.png"):
        read_ground_truth(path).locate(tmp_path / "recording" / "none")


@pytest.mark.parametrize("text", ["{}\n{}\n", "[]"])
def test_objects_without_a_name_are_no_table(text: str, tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text(text)
    with refused("table-empty"):
        read_table(tmp_path / "a.json")
