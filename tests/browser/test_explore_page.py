"""The explorer as a visitor uses it."""

import csv
import io
import re
import time
from pathlib import Path

import pytest
from walk import (
    DRAWN,
    choose,
    colours,
    dots,
    farthest,
    fault,
    numbers,
    open_page,
    slide,
    wait_for_dots,
    wait_for_motion,
    wait_for_numbers,
)

from errors import check_values
from palpate.viewer.labels import column_label


def test_a_dome_is_on_the_screen_with_everything_around_it(page, link):
    start = time.monotonic()
    open_page(page, link)
    assert time.monotonic() - start < 30  # the figure is for a machine that does nothing else
    assert colours(page) > 50
    assert page.locator(".dome-view[data-drawn]").count() == 1, "the hidden view costs nothing"
    assert len(dots(page)) == 19
    assert page.get_by_test_id("kept").is_visible()
    assert numbers(page, "kept") == [2, 2]
    assert page.locator(".heat svg").count() == 1


def test_the_press_is_scrubbed_turned_and_tilted(page, link):
    open_page(page, link)
    rest = dots(page)
    slide(page, "depth", 3.5)
    pressed = dots(page)
    assert farthest(rest, pressed) > 1
    slide(page, "tilt", 6)
    wait_for_motion(page, pressed, 10, 0.2)
    tilted = dots(page)
    slide(page, "azimuth", 90)
    wait_for_motion(page, tilted, 10, 0.2)
    assert page.locator(".pose-bar output").nth(2).inner_text() == "90 °"


def test_triangles_are_sent_once(page, link):
    asked = []
    page.on("request", lambda request: asked.append(request.url))
    open_page(page, link)
    for depth in (1, 2, 3):
        slide(page, "depth", depth)
    slide(page, "tilt", 2)
    page.wait_for_timeout(500)
    assert sum("/data/shell/" in address for address in asked) == 1
    assert sum("/data/motion/" in address for address in asked) == 2  # one a tilt, none a depth


def test_a_clicked_cell_is_shown(page, link):
    open_page(page, link)
    box = page.locator(".heat svg").bounding_box()
    page.mouse.click(box["x"] + box["width"] * 0.28, box["y"] + box["height"] * 0.35)  # the only cell of 7 markers
    wait_for_dots(page, 7)
    page.wait_for_url(re.compile("design=0"))


def test_designs_are_filtered_and_a_wrong_question_is_answered_in_place(page, link):
    open_page(page, link)
    question = page.get_by_test_id("where")
    question.fill("markers > 7")
    wait_for_numbers(page, "kept", [1, 2])
    question.fill("markers >")
    check_values(fault(page, "question-malformed", "kept"), "markers >")
    question.fill("marker > 7")
    check_values(fault(page, "column-unknown", "kept"), "'marker'", "'markers'")
    question.fill("")
    wait_for_numbers(page, "kept", [2, 2])
    assert colours(page) > 50


def test_metric_and_axes_change(page, link):
    open_page(page, link)
    choose(page, "metric", column_label("travel_mm"))
    page.wait_for_url(re.compile("metric=travel_mm"))
    choose(page, "across", column_label("height_mm"))
    page.wait_for_url(re.compile("across=height_mm"))


@pytest.mark.parametrize("colour", ["stress", "contact"])
def test_the_dome_is_coloured_by(page, link, colour):
    open_page(page, link, "?depth=3")
    legend = page.locator(".dome-legend b").first
    before = legend.inner_text()
    page.get_by_test_id("colour").get_by_role("button", name=colour, exact=True).click()
    page.wait_for_function(f"document.querySelector('.dome-legend b').dataset.colour === '{colour}'")
    assert legend.inner_text() != before
    assert legend.inner_text().endswith({"stress": "(MPa)", "contact": "(mm)"}[colour])
    page.wait_for_function("document.querySelector('.dome-note').textContent === ''")
    assert colours(page) > 50


def test_two_designs_are_compared(page, link, designs):
    open_page(page, link, "?depth=3&design=1")
    choose(page, "second-design", designs[0])
    page.wait_for_function("document.querySelectorAll('.camera-view')[1].querySelectorAll('circle').length > 0")
    assert page.locator(".dome-view:visible").count() == 2
    page.wait_for_function("Number(document.querySelectorAll('.dome-view')[1].dataset.drawn) > 0")
    assert page.get_by_test_id("figures").locator("tr").first.inner_text().count("H20") == 2


def test_a_link_restores_the_view(page, link):
    open_page(page, link, "?design=0&depth=2.5&tilt=4&azimuth=120&colour=contact&cut=0&where=markers+%3C+10")
    wait_for_numbers(page, "kept", [1, 2])
    assert [text.strip() for text in page.locator(".pose-bar output").all_inner_texts()] == [
        "2.50 mm",
        "4.0 °",
        "120 °",
    ]
    assert page.locator(".dome-legend b").first.get_attribute("data-colour") == "contact"
    assert page.locator(".dome-legend b").first.inner_text().endswith("(mm)")
    assert len(dots(page)) == 7
    first = dots(page)
    address = page.url
    open_page(page, address)
    assert farthest(first, dots(page)) < 0.01


def test_a_wrong_link_is_reported_in_place(page, link):
    open_page(page, link, "?design=99&tilt=nan&colour=red&where=%3B")
    check_values(fault(page, "link-malformed"), "design", "tilt", "colour", "where")
    assert colours(page) > 50


EXPORTS = (
    ("dome.png", b"\x89PNG"),
    ("camera.svg", b"<svg"),
    ("heat_maps.svg", b"<svg"),
    ("dome.glb", b"glTF"),
    ("grid.csv", b"height_mm"),
    ("markers.csv", b"rx_deg"),
)


def test_what_is_seen_is_exported(page, link):
    open_page(page, link, "?depth=2")
    for name, begins in EXPORTS:
        page.get_by_test_id("export").click()
        with page.expect_download() as download:
            page.get_by_test_id("export-" + re.sub("[._]", "-", name)).click()
        assert download.value.suggested_filename == name
        content = Path(download.value.path()).read_bytes()
        assert content.startswith(begins)
    assert {row["marker"] for row in csv.DictReader(io.StringIO(content.decode()))} == {str(i) for i in range(19)}


def test_the_view_turns_by_keys(page, link):
    open_page(page, link, "?depth=2")
    canvas = page.locator(".dome-view canvas").first
    canvas.focus()
    before = int(page.locator(".dome-view").first.get_attribute("data-drawn"))
    for key in ("ArrowLeft", "ArrowUp", "+"):
        page.keyboard.press(key)
    assert int(page.locator(".dome-view").first.get_attribute("data-drawn")) >= before + 3
    slider = page.locator(".pose-bar input[name=depth]")
    slider.focus()
    page.keyboard.press("ArrowRight")
    assert page.locator(".pose-bar output").first.inner_text() == "2.02 mm"


@pytest.mark.parametrize("path", ["", "design", "live"])
def test_every_control_has_a_name_and_is_reached_by_keys(page, link, path):
    page.goto(link + path)
    page.wait_for_function("document.querySelector('.dial')" if path == "live" else DRAWN)
    nameless = page.evaluate(
        """() => [...document.querySelectorAll('button, input, a, canvas[tabindex], [role=slider], [role=checkbox]')]
        .filter(e => e.offsetParent && !(e.getAttribute('aria-label') || e.getAttribute('aria-labelledby')
            || e.labels?.length || e.textContent.trim() || e.closest('[aria-label]') || e.title))
        .map(e => e.outerHTML.slice(0, 120))"""
    )
    assert nameless == []
    reached = set()
    for _ in range(60):
        page.keyboard.press("Tab")
        reached.add(page.evaluate("document.activeElement?.tagName + ':' + (document.activeElement?.id || '')"))
        if len(reached) > 8:
            break
    assert len(reached) > 8
