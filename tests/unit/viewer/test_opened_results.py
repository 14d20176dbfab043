"""Results below a folder: found by their kinds, listed, and opened by name."""

import os

import h5py
import numpy as np
import pytest

from errors import check_values, refused
from palpate.mechanics import SolverSpec
from palpate.surrogate import TWIN_DERIVATIVES, write_twin
from palpate.viewer.opened_results import describe_result, find_results, kind_of
from presses import build_twin, solve_press
from small_search import write_search

pytest.importorskip("nicegui", reason="the extra web is not there: pip install -e '.[web]'")

from made_up_presses import MESH, made_up_press, write_results

from palpate.design import MarkerLayout
from palpate.fea import WallSpec, write_press
from palpate.material import get_material
from palpate.viewer.opened_results import OpenedResults
from palpate.viewer.pressed_skin import build_pressed_skin
from palpate.viewer.server import ServeSpec, serve

FOUND = {
    "link": "search",
    "my study #1": "study",
    "my study #1/twins/H20_T2.h5": "twin",
    "press.h5": "press",
    "search": "search",
}


def small_twin():
    material, spec = get_material("zaid_2024_ecoflex_00_30"), SolverSpec(derivatives=TWIN_DERIVATIVES, edge_share=1.0)
    walls = (WallSpec(tilt_deg=tilt, depth=4.0, depth_step=0.5) for tilt in (0.0, 3.0, 6.0, 9.0))
    return build_twin([solve_press(MESH, material, wall, spec) for wall in walls])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A study with a twin, a search and a press; and what is no result."""
    pytest.importorskip("optuna")
    place = tmp_path_factory.mktemp("results")
    for name in ("my study #1/twins", "search", ".hidden", "notes"):
        (place / name).mkdir(parents=True)
    write_results(place / "my study #1")
    write_results(place / ".hidden")
    write_search(place / "search", finished=True)
    write_press(place / "press.h5", made_up_press(3.0))
    write_twin(place / "my study #1" / "twins" / "H20_T2.h5", small_twin())
    (place / "notes" / "half.h5").write_bytes((place / "press.h5").read_bytes()[:900])
    with h5py.File(place / "notes" / "other.h5", "w") as file:
        file.attrs["kind"] = "something else"
    (place / "link").symlink_to(place / "search")
    return place


def test_results_are_found_by_their_kinds_without_stores_and_hidden_folders(folder):
    assert {name: kind_of(path) for name, path in find_results(folder).items()} == FOUND
    assert find_results(folder / "search") == {"": folder / "search"}
    assert find_results(folder / "press.h5") == {"": folder / "press.h5"}
    assert find_results(folder / "notes") == find_results(folder / "notes" / "half.h5") == {}


def test_a_list_has_kind_number_and_date(folder):
    os.utime(folder / "press.h5", (0, 86_400 * 366))
    rows = {name: describe_result(path) for name, path in find_results(folder).items()}
    assert {name: kind for name, (kind, _, _) in rows.items()} == FOUND
    for name, count in (("my study #1", "3 designs"), ("my study #1/twins/H20_T2.h5", "4 presses")):
        assert rows[name][1] == count
    assert rows["search"][1] == "8 skins"
    assert rows["press.h5"][1] == "1 press"
    assert rows["press.h5"][2].startswith("1971-01-02")


def test_an_unreadable_result_is_listed_with_its_reason(tmp_path):
    (tmp_path / "grid.json").write_text("{")
    with h5py.File(tmp_path / "old.h5", "w") as file:
        file.attrs["kind"] = "palpate calibration predict"
    for path in (tmp_path, tmp_path / "old.h5"):
        check_values(describe_result(path)[1], path)


@pytest.mark.parametrize("name", ["", "nothing", "../results", "/etc/passwd", "notes/half.h5", ".hidden"])
def test_only_results_of_the_list_are_opened(folder, name):
    with refused("result-unknown", name, folder):
        OpenedResults(folder).open(name)


def test_a_result_that_comes_later_is_opened(tmp_path):
    opened = OpenedResults(tmp_path)
    with refused("result-unknown"):
        opened.open("new")
    (tmp_path / "new").mkdir()
    write_results(tmp_path / "new")
    assert opened.open("new") is opened.open("new")


def test_a_folder_without_results_is_refused_before_a_port_is_taken(folder):
    with refused("results-missing", folder / "notes"):
        serve(folder / "notes", ServeSpec(), pytest.fail)


def test_a_press_alone_is_drawn_without_markers():
    pressed = build_pressed_skin([made_up_press(3.0)])
    none = MarkerLayout(np.zeros((0, 3)), 1.0)
    assert pressed.positions(none, pressed.at(3.0), 20.0).shape == (6, 0, 3)
