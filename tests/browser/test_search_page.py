"""The page of a search: the front, a design that is clicked, pressed and made."""

import shutil
import zipfile
from pathlib import Path

import pytest
from viewer_process import viewer
from walk import DRAWN, choose, dots, fault, numbers, open_page, wait_for_dots, wait_for_numbers, wait_for_state

from errors import check_refusal, check_values
from needs import needs
from palpate.cli import main
from palpate.mechanics import EndReason
from palpate.optimise import read_search
from palpate.viewer.labels import column_label
from small_search import write_search


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    needs("optuna")
    place = tmp_path_factory.mktemp("search")
    write_search(place, finished=True)
    return place


@pytest.fixture(scope="module")
def search(folder):
    with viewer(folder) as address:
        yield address


def click_point(page, number):
    """Click a design's point in the chart once the page no longer moves; as a person does, again if it was missed."""
    shown = page.locator(f"[data-testid=shown][data-design='{number}']")
    for _ in range(3):
        before, place = None, _point(page, number)
        while place != before:
            page.wait_for_timeout(200)
            before, place = place, _point(page, number)
        page.mouse.click(*place)
        for _ in range(75):
            if shown.count():
                return
            page.wait_for_timeout(200)
    raise AssertionError(f"three clicks at {place} did not show design {number}")


def _point(page, number):
    """Centre of a design's point in the window, px."""
    return page.evaluate(
        """number => { const front = document.querySelector('.front'); front.scrollIntoView({block: 'center'});
        const chart = getElement(Number(front.id.slice(1))).chart; const box = front.getBoundingClientRect();
        const series = chart.getOption().series;
        for (let i = 0; i < series.length; i++) for (const d of series[i].data) if (d.value[2] === number) {
          const [x, y] = chart.convertToPixel({seriesIndex: i}, d.value.slice(0, 2));
          return [box.x + x, box.y + y]; }}""",
        number,
    )


def test_a_click_on_the_front_shows_the_design_with_its_numbers_and_its_skin(page, search, folder):
    found = read_search(folder)
    open_page(page, search)
    shown = page.get_by_test_id("shown")
    wait_for_numbers(page, "shown", [found.rows[found.winner]["skin"], 37])
    assert shown.get_attribute("data-role") == "winner"
    wait_for_dots(page, 37)
    few = next(k for k in range(found.front) if found.rows[k]["markers"] == 7)
    click_point(page, few)
    wait_for_numbers(page, "shown", [found.rows[few]["skin"], 7])
    assert [shown.get_attribute(f"data-{name}") for name in ("design", "role")] == [str(few), "front"]
    wait_for_dots(page, 7)
    height = page.locator("[data-testid=figures] [data-column=height_mm] td").inner_text()
    assert float(height) == pytest.approx(float(found.rows[few]["height_mm"]), abs=5e-4)
    choose(page, "across", column_label("markers"))
    page.wait_for_function("document.querySelector('.front').textContent.includes('markers')")
    before = dots(page)
    page.reload()
    page.wait_for_function(DRAWN)
    wait_for_dots(page, 7)
    assert dots(page) == before, "the link keeps the design"


def test_a_running_search_shows_what_was_tried(page, folder, tmp_path):
    running = tmp_path / "running"
    running.mkdir()
    for name in ("requirements.json", "search.journal"):
        shutil.copy(folder / name, running / name)
    with viewer(running) as link:
        open_page(page, link)
        page.locator("[data-testid=search-state][data-finished=false]").wait_for()
        assert numbers(page, "search-state")[:2] == [8, 8]
        shutil.copytree(folder, running, dirs_exist_ok=True)
        page.locator("[data-testid=search-state][data-finished=true]").wait_for()
        page.goto(link + "live")
        fault(page, "model-missing")
        page.goto("about:blank")


def test_a_folder_of_neither_grid_nor_search_ends_with_one_sentence(tmp_path, capsys):
    with pytest.raises(SystemExit) as left:
        main(["view", str(tmp_path), "--port", "0"])
    assert left.value.code == 2
    said = capsys.readouterr().err
    check_refusal(said, "results-missing", tmp_path)
    assert "Traceback" not in said


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("size", [(1280, 800), (390, 844)], ids=["1280x800", "390x844"])
def test_the_page_fits_the_screen(page, search, pictures, size, dark):
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.context.add_cookies([{"name": "palpate_dark", "value": str(int(dark)), "url": search}])
    open_page(page, search)
    page.wait_for_function("document.querySelectorAll('.front svg path').length > 0")
    page.screenshot(path=pictures / f"search_{size[0]}_{'dark' if dark else 'light'}.png", full_page=True)
    assert page.evaluate("document.documentElement.scrollWidth") <= size[0]


@pytest.mark.slow
def test_a_design_of_the_front_is_pressed_and_its_pack_is_made(page, search):
    needs("build123d")
    open_page(page, search)
    page.get_by_test_id("field-depth").fill("1")
    page.get_by_test_id("press").click()
    wait_for_state(page, "pressed", timeout=420_000)
    check_values(page.get_by_test_id("force-note").inner_text(), EndReason.DEPTH_REACHED, "1.00 mm")
    with page.expect_download(timeout=240_000) as download:
        page.get_by_test_id("make").click()
    with zipfile.ZipFile(Path(download.value.path())) as pack:
        assert {"pack/instructions.pdf", "pack/manifest.json", "pack/mold.step"} <= set(pack.namelist())
        assert pack.testzip() is None
