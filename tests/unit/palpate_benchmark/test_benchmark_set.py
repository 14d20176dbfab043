"""The open set: the same bytes each time, clean splits, what its files say against pictures and solved presses."""

import csv
import hashlib
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import cv2
import numpy as np
import pytest
from palpate_benchmark import PRESETS, BenchmarkSet, make_benchmark, read_set
from palpate_benchmark.set_files import digest
from palpate_benchmark.simulate_unit import deviation_of
from scipy.spatial import cKDTree

from errors import refused
from needs import needs
from palpate.camera import build_camera
from palpate.design import build_skin, place_markers, wall_normal
from palpate.fea import WallSpec
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin
from palpate.vision import prepare_detector
from presses import solve_press

TINY = PRESETS["tiny"]
SPEC = TINY.model_copy(update={"designs": TINY.designs[1:], "pictures": 2})
SPLITS = ("train", "calibrate", "test")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("made")
    make_benchmark(SPEC, out, workers=1)
    return out


@pytest.fixture(scope="module")
def made_set(made: Path) -> BenchmarkSet:
    return read_set(made / "set")


def checksums(folder: Path) -> dict[str, str]:
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(folder.iterdir())}


def rows_of(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_made_again_from_nothing_by_more_workers_it_has_the_same_bytes(made: Path, tmp_path: Path) -> None:
    make_benchmark(SPEC, tmp_path, workers=2)
    assert checksums(tmp_path / "set") == checksums(made / "set")


def test_killed_and_made_on_it_has_the_same_bytes(made: Path, tmp_path: Path) -> None:
    for kind in ("press", "twin"):
        shutil.copytree(made / "store" / kind, tmp_path / "store" / kind)
    program = (
        "import sys; from pathlib import Path; from palpate_benchmark import PRESETS, make_benchmark\n"
        "if __name__ == '__main__':\n"
        "    tiny = PRESETS['tiny']\n"
        "    spec = tiny.model_copy(update={'designs': tiny.designs[1:], 'pictures': 2})\n"
        "    make_benchmark(spec, Path(sys.argv[1]), workers=1)\n"
    )
    (tmp_path / "program.py").write_text(program)
    process = subprocess.Popen([sys.executable, str(tmp_path / "program.py"), str(tmp_path)])
    units = tmp_path / "store" / "benchmark"
    end = time.monotonic() + 120
    while not list(units.rglob("*.h5")):
        assert process.poll() is None, "it ended before a unit was drawn"
        assert time.monotonic() < end
        time.sleep(0.01)
    process.send_signal(signal.SIGKILL)
    process.wait()
    drawn = len(list(units.rglob("*.h5")))
    assert 0 < drawn < SPEC.units
    assert not (tmp_path / "set").exists()
    make_benchmark(SPEC, tmp_path, workers=1)
    assert checksums(tmp_path / "set") == checksums(made / "set")


def test_the_list_of_checksums_is_that_of_the_files(made_set: BenchmarkSet) -> None:
    lines = (made_set.folder / "SHA256SUMS").read_text().splitlines()
    listed = dict(reversed(line.split("  ")) for line in lines)
    found = checksums(made_set.folder)
    del found["SHA256SUMS"]
    assert listed == found
    assert digest(made_set.folder / "train.h5") == found["train.h5"]


def test_no_unit_no_press_and_no_image_is_on_two_sides(made_set: BenchmarkSet) -> None:
    tables = {split: made_set.table(split) for split in SPLITS}
    units = [{*zip(table.design, table.unit, strict=True)} for table in tables.values()]
    presses = [{*table.press.tolist()} for table in tables.values()]
    poses = [{*map(tuple, table.labels[:, :2])} for table in tables.values()]
    for sides in (units, presses, poses):
        assert sum(map(len, sides)) == len(set.union(*sides))
    images = np.concatenate([table.image for table in tables.values()])
    assert sorted(images) == list(range(SPEC.units * SPEC.presses * SPEC.images))
    for split, table in tables.items():
        assert {SPEC.split_of(unit) for unit in table.unit} == {split}
        for press in np.unique(table.press):
            assert len({*zip(table.design[table.press == press], table.unit[table.press == press], strict=True)}) == 1


def test_the_test_tells_neither_labels_nor_order(made_set: BenchmarkSet) -> None:
    assert list(rows_of(made_set.folder / "test.csv")[0]) == ["image", "design", "unit", "picture"]
    table = made_set.table("train")
    depth = table.labels[:, 2]
    assert abs(np.corrcoef(table.image, depth)[0, 1]) < 0.2
    assert (np.diff(table.press) == 0).mean() < 0.2, "images of a press stand together"
    markers = made_set.markers("test", SPEC.designs[0].name)
    assert (np.diff(markers.image) > 0).all()


def test_a_seed_of_its_own_changes_the_test_and_stands_in_no_file(made: Path, tmp_path: Path) -> None:
    for kind in ("press", "twin"):
        shutil.copytree(made / "store" / kind, tmp_path / "store" / kind)
    hidden = SPEC.model_copy(update={"hidden_seed": 987654321, "pictures": 0})
    make_benchmark(hidden, tmp_path, workers=1)
    plain, secret = read_set(made / "set"), read_set(tmp_path / "set")

    def labels(made_set: BenchmarkSet, split: str) -> list[tuple[float, ...]]:
        return sorted(map(tuple, made_set.table(split).labels))  # type: ignore[arg-type]

    assert labels(plain, "train") == labels(secret, "train")
    assert labels(plain, "test") != labels(secret, "test")
    for path in (tmp_path / "set").iterdir():
        assert b"987654321" not in path.read_bytes(), path.name


def test_dots_are_where_a_picture_shows_them(made_set: BenchmarkSet) -> None:
    table, design = made_set.table("train"), SPEC.designs[0].name
    markers = made_set.markers("train", design)
    row = int(np.flatnonzero(table.picture != "")[0])
    camera = SPEC.camera
    picture = made_set.pictures("train", [str(table.picture[row])], (camera.height_px, camera.width_px))[0]
    noted = markers.markers_px[markers.image == table.image[row]][0]
    noted = noted[np.isfinite(noted).all(axis=1)]
    away, _ = cKDTree(prepare_detector(picture).find(picture).positions_px).query(noted)
    assert np.median(away) < 0.25
    assert (away < 1.0).mean() > 0.9


def test_images_and_forces_are_those_of_a_press_solved_anew(made_set: BenchmarkSet) -> None:
    """A press of the unit's own wall thickness at the label's pose, not interpolated; on the twin's coarse mesh."""
    design = SPEC.designs[0]
    table, markers = made_set.table("train"), made_set.markers("train", design.name)
    row = int(np.argmax(table.labels[:, 2]))
    rx, ry, depth, force = table.labels[row, :4]
    unit = int(table.unit[row])
    deviation = deviation_of(SPEC, design, unit)
    wall = WallSpec(
        tilt_deg=float(np.hypot(rx, ry)), azimuth_deg=float(np.degrees(np.arctan2(ry, rx))), depth=float(depth)
    )
    mesh = mesh_skin(build_skin(deviation.dome(design.skin)), MeshSpec(cells=SPEC.twin.cells))
    press = solve_press(mesh, deviation.material(get_material(SPEC.material)), wall)
    layout = place_markers(build_skin(design.skin), design.marker_layout)
    camera = build_camera(deviation.camera(SPEC.camera))
    moved = camera.project(press.positions(layout.positions)[-1]) - camera.project(layout.positions)
    seen = markers.markers_px[markers.image == table.image[row]][0] - markers.rest_px[unit]
    there = np.isfinite(seen).all(axis=1)
    # of a misprint of 0.1 mm and of the twin's interpolation over tilts 0.06 px are left
    assert np.sqrt((moved[there] ** 2).mean()) > 1.5
    assert np.sqrt(((moved - seen)[there] ** 2).mean()) < 0.1
    pressing = press.force[-1] @ wall_normal(np.radians(wall.tilt_deg), 0.0)
    assert pressing == pytest.approx(force, rel=0.15)  # four cells, tilts 4 degrees apart; on 11 cells 6 % at most


def test_croissant_reads_every_table_and_picture(made_set: BenchmarkSet) -> None:
    mlcroissant = needs("mlcroissant")
    dataset = mlcroissant.Dataset(jsonld=str(made_set.folder / "croissant.json"))
    assert not dataset.metadata.issues.errors
    assert not dataset.metadata.issues.warnings
    for name in ("train", "hidden", "layouts", "calibrate_units"):
        records = list(dataset.records(name))
        rows = rows_of(made_set.folder / f"{name}.csv")
        assert len(records) == len(rows)
        for key, text in rows[1].items():
            value = records[1][f"{name}/{key}"]
            if isinstance(value, float):
                assert value == pytest.approx(float(text))
            else:
                assert (value.decode() if isinstance(value, bytes) else str("" if value is None else value)) == text
    listed = {item.id for item in dataset.metadata.distribution}
    assert {path.name for path in made_set.folder.iterdir()} - listed == {"croissant.json", "SHA256SUMS"}


def test_pictures_are_grey_and_of_the_cameras_size(made_set: BenchmarkSet) -> None:
    table = made_set.table("test")
    names = table.picture[table.picture != ""].tolist()
    assert len(names) == SPEC.test_units * SPEC.pictures
    rest = f"test/rest_{SPEC.designs[0].name}_{SPEC.units:02d}.png"
    pictures = made_set.pictures("test", [rest, *names], (SPEC.camera.height_px, SPEC.camera.width_px))
    assert pictures.shape == (len(names) + 1, 260, 346)
    assert all(cv2.absdiff(pictures[0], one).mean() > 1.0 for one in pictures[1:])


def test_what_is_no_set_is_refused(tmp_path: Path) -> None:
    with refused("benchmark-missing"):
        read_set(tmp_path)


@pytest.mark.parametrize("number", ["9" * 21, "one", ""])
def test_a_damaged_number_of_a_table_is_refused(made_set: BenchmarkSet, number: str, tmp_path: Path) -> None:
    shutil.copytree(made_set.folder, tmp_path / "set", ignore=shutil.ignore_patterns("*.h5", "*.png"))
    path = tmp_path / "set" / "test.csv"
    head, first, *rows = path.read_text().splitlines()
    at = head.split(",").index("unit")
    cells = first.split(",")
    path.write_text("\n".join([head, ",".join([*cells[:at], number, *cells[at + 1 :]]), *rows, ""]))
    with refused("benchmark-table-damaged", "test"):
        read_set(tmp_path / "set").table("test")
