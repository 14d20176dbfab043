"""A folder of results: listed, opened by a click or a key, and left again."""

import re
import shutil
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from viewer_process import viewer
from walk import DRAWN, colours, dots, fault, numbers, open_page, slide, wait_for_numbers

from needs import needs
from small_search import write_search


@pytest.fixture(scope="module")
def shelf(results, tmp_path_factory) -> Path:
    """A folder of a study, a search, and a press file."""
    needs("optuna")
    place = tmp_path_factory.mktemp("shelf")
    shutil.copytree(results, place / "study #1")
    (place / "search").mkdir()
    write_search(place / "search", finished=True)
    shutil.copy(next((results / "store" / "press").rglob("*.h5")), place / "press.h5")
    return place


@pytest.fixture(scope="module")
def listed(shelf) -> Iterator[str]:
    with viewer(shelf) as address:
        yield address


def rows(page):
    found = page.locator("table.errors tr").all_inner_texts()[1:]
    return [[cell.strip() for cell in row.split("\t")[:3]] for row in found]


def test_results_are_listed_and_opened_by_a_click(page, listed):
    page.goto(listed)
    assert sorted(rows(page)) == [
        ["press.h5", "press", "1 press"],
        ["search", "search", "8 skins"],
        ["study #1", "study", "2 designs"],
    ]
    page.get_by_role("link", name="study #1").click()
    page.wait_for_function(DRAWN)
    assert numbers(page, "kept") == [2, 2]
    slide(page, "depth", 3)
    page.wait_for_url(re.compile(r"result=study\+%231.*depth=3"))
    before = dots(page)
    page.reload()
    page.wait_for_function(DRAWN)
    assert dots(page) == before, "the link keeps the result and its view"
    page.get_by_role("link", name="Live", exact=True).click()
    page.get_by_test_id("start").wait_for()
    page.get_by_role("link", name="Results", exact=True).click()
    page.wait_for_function("document.querySelectorAll('table.errors tr').length === 4")


def test_a_search_is_opened_by_keys_and_keeps_its_name(page, listed):
    page.goto(listed)
    page.get_by_role("link", name="search").focus()
    page.keyboard.press("Enter")
    page.wait_for_function(DRAWN)
    wait_for_numbers(page, "shown", [numbers(page, "shown")[0], 37])
    page.get_by_role("link", name="Explore", exact=True).click()
    page.wait_for_function(DRAWN)
    assert "result=search" in page.url
    page.get_by_role("link", name="Live", exact=True).click()
    fault(page, "model-missing")


def test_a_press_is_drawn_and_downloaded(page, listed):
    needs("meshio")
    page.goto(listed + "?result=press.h5")
    page.wait_for_function("document.querySelector('.pose-bar input[name=depth]').valueAsNumber > 3.9")
    assert colours(page) > 50
    with page.expect_download() as download:
        page.get_by_test_id("export").click()
    with zipfile.ZipFile(Path(download.value.path())) as archive:
        assert {"press/press.pvd", "press/press_0000.vtu", "press/force.csv"} <= set(archive.namelist())


def test_a_result_that_is_not_there_is_named(page, listed):
    page.goto(listed + "?result=..%2Fother")
    assert "../other" in fault(page, "result-unknown")


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("size", [(1280, 800), (390, 844)], ids=["1280x800", "390x844"])
def test_the_pages_fit_the_screen(page, listed, pictures, size, dark):
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.context.add_cookies([{"name": "palpate_dark", "value": str(int(dark)), "url": listed}])
    for title, query in {"list": "", "press": "?result=press.h5", "opened": "?result=study+%231&depth=3"}.items():
        page.goto(listed + query)
        page.locator("table.errors a" if title == "list" else ".dome-view[data-drawn]").first.wait_for()
        page.wait_for_timeout(400)
        page.screenshot(path=pictures / f"{title}_{size[0]}_{'dark' if dark else 'light'}.png", full_page=True)
        assert page.evaluate("document.documentElement.scrollWidth") <= size[0], title


def test_a_folder_of_results_here_is_opened_without_being_named(page, shelf, tmp_path):
    (tmp_path / "results").symlink_to(shelf)
    with viewer(cwd=tmp_path) as link:
        page.goto(link)
        page.get_by_role("link", name="study #1").wait_for()
        page.goto("about:blank")


def test_a_press_by_a_ball_says_where_it_can_be_seen(page, tmp_path):
    from palpate.design import DomeSpec
    from palpate.fea import BallSpec, write_press
    from palpate.material import get_material
    from palpate.mechanics import SolverSpec
    from palpate.mesh import MeshSpec, mesh_skin
    from presses import solve_press

    mesh = mesh_skin(DomeSpec().build(), MeshSpec(cells=6))
    ball = BallSpec(depth=0.8)
    write_press(tmp_path / "ball.h5", solve_press(mesh, get_material("neo-hooke:0.1"), ball, SolverSpec()))
    with viewer(tmp_path / "ball.h5") as link:
        page.goto(link)
        assert "ball" in fault(page, "obstacle-not-drawn")
        with page.expect_download():
            page.get_by_test_id("export").click()
        page.goto("about:blank")


def test_the_nearest_press_of_a_view_is_downloaded(page, listed):
    needs("meshio")
    open_page(page, listed, "?result=study+%231&depth=2&tilt=4")
    page.get_by_test_id("export").click()
    with page.expect_download() as download:
        page.get_by_test_id("export-press-zip").click()
    assert zipfile.ZipFile(Path(download.value.path())).testzip() is None
