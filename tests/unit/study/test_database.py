import json
import sqlite3
from contextlib import closing

import pytest

from errors import refused
from palpate.study import evaluate_grid, read_grid, write_grid
from palpate.study.grid_database import read_database, write_database
from results import FIRST, LIMITS, leave_out_pictures, make_design


def ask(path, question):
    with closing(sqlite3.connect(path)) as database:
        return database.execute(question).fetchall()


@pytest.fixture
def grid():
    return evaluate_grid([*FIRST, make_design(thickness=4.0, failure="stopped")])


@pytest.fixture
def path(tmp_path, grid):
    write_database(tmp_path / "grid.sqlite", grid)
    return tmp_path / "grid.sqlite"


def test_database_gives_the_same_grid_back(path, grid):
    again = read_database(path)
    assert again == grid
    assert [type(cell) for cell in again.designs[0].values()] == [type(cell) for cell in grid.designs[0].values()]


def test_other_programs_can_ask_it(path, grid):
    found = ask(path, "SELECT markers, rmse_deg FROM design WHERE rmse_deg < 1 AND height_mm <= 20 ORDER BY rmse_deg")
    expected = sorted((row["rmse_deg"], row["markers"]) for row in grid.designs if (row["rmse_deg"] or 9) < 1)
    assert [(rmse, markers) for markers, rmse in found] == expected


def test_depths_and_tilts_are_rows(path, grid):
    found = ask(path, "SELECT depth_mm, rmse_jitter_deg, bound_deg FROM by_depth WHERE design = 0 ORDER BY depth_mm")
    shallow, deep = (row["rmse_jitter_deg"] for row in grid.by_depth[:2])
    assert found == [(2.4, shallow, LIMITS[0].least_squares_deg), (8.0, deep, LIMITS[1].least_squares_deg)]
    found = ask(path, "SELECT tilt_from_deg, tilt_to_deg, validation_samples FROM by_tilt WHERE design = 0")
    assert found == [(4, 6, 4)]
    found = ask(path, "SELECT tilt_deg, branch FROM presses WHERE design = 0 AND branch = 'inverted'")
    assert found == [(12.0, "inverted")]


def test_provenance_goes_down_to_the_press(path):
    facts = ask(path, "SELECT kind, name, value FROM provenance WHERE design = 0")
    assert [value for kind, _, value in facts if kind == "press_key"] == ["aa", "bb"]
    assert ("versions", "fea", "1") in facts
    assert ("estimator_key", "0", "ff") in facts
    assert [json.loads(value) for kind, _, value in facts if kind == "spec"] == [{"dataset": {"seed": 4}}]


def test_a_version_with_a_space_in_it_survives(tmp_path):
    from dataclasses import replace

    grid = evaluate_grid([replace(make_design(), versions={"fea": "1", "platform": "Linux x86_64", "py-x": "2"})])
    write_database(tmp_path / "grid.sqlite", grid)
    found = ask(tmp_path / "grid.sqlite", "SELECT value FROM provenance WHERE name = 'platform'")
    assert found == [("Linux x86_64",)]
    assert read_database(tmp_path / "grid.sqlite") == grid


def test_it_is_in_wal_mode_and_leaves_no_second_file(path):
    assert ask(path, "PRAGMA journal_mode") == [("wal",)]
    assert [item.name for item in path.parent.iterdir()] == ["grid.sqlite"]


def test_a_reader_keeps_the_older_grid_while_a_new_one_is_written(path, grid):
    with closing(sqlite3.connect(path, isolation_level=None)) as reader:
        reader.execute("BEGIN")
        before = reader.execute("SELECT count(*) FROM design").fetchone()
        write_database(path, evaluate_grid([make_design()]))
        assert reader.execute("SELECT count(*) FROM design").fetchone() == before == (len(grid.designs),)
        reader.execute("COMMIT")
        assert reader.execute("SELECT count(*) FROM design").fetchone() == (1,)


def test_a_file_that_is_no_database_is_replaced(tmp_path, grid):
    (tmp_path / "grid.sqlite").write_bytes(b"not a database" * 100)
    write_database(tmp_path / "grid.sqlite", grid)
    assert read_database(tmp_path / "grid.sqlite") == grid


@pytest.mark.parametrize(("version", "says"), [(1, ("grid-older", 1)), (99, ("grid-other", 99))])
def test_another_schema_is_refused_and_says_what_to_do(path, version, says):
    with closing(sqlite3.connect(path)) as database:
        database.execute(f"PRAGMA user_version = {version}")
    with refused(*says):
        read_database(path)


@pytest.mark.parametrize("content", [b"", b"not a database" * 100])
def test_a_broken_file_is_reported(tmp_path, content):
    (tmp_path / "grid.sqlite").write_bytes(content)
    with refused("grid-unreadable"):
        read_grid(tmp_path)


def test_a_folder_that_may_not_be_written_is_read(path, grid):
    path.parent.chmod(0o555)
    try:
        assert read_grid(path.parent) == grid
    finally:
        path.parent.chmod(0o755)


def test_a_folder_without_a_database_is_read_from_its_json(tmp_path, grid, monkeypatch):
    leave_out_pictures(monkeypatch)
    write_grid(tmp_path, grid)
    (tmp_path / "grid.sqlite").unlink()
    assert read_grid(tmp_path) == grid


def test_an_empty_grid_is_kept(tmp_path):
    write_database(tmp_path / "grid.sqlite", evaluate_grid([]))
    assert read_database(tmp_path / "grid.sqlite").designs == ()


@pytest.mark.parametrize(
    "change",
    [
        "PRAGMA application_id = 7",
        "UPDATE design SET design = design + 1 WHERE design = (SELECT max(design) FROM design)",
        "UPDATE design SET markers = x'00' WHERE design = 0",
        "UPDATE by_depth SET design = 99",
    ],
)
def test_a_database_of_another_kind_or_with_a_changed_cell_is_refused(path, change):
    with closing(sqlite3.connect(path, isolation_level=None)) as database:
        database.execute(change)
    with refused("grid-unreadable"):
        read_database(path)
