"""The explorer as a visitor uses it."""

import csv
import io
import math
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


@pytest.mark.parametrize("colour", ["stress", "pressure", "contact"])
def test_the_dome_is_coloured_by(page, link, colour):
    open_page(page, link, "?depth=3")
    legend = page.locator(".dome-legend b").first
    before = legend.inner_text()
    page.get_by_test_id("colour").get_by_role("button", name=colour, exact=True).click()
    page.wait_for_function(f"document.querySelector('.dome-legend b').dataset.colour === '{colour}'")
    assert legend.inner_text() != before
    assert legend.inner_text().endswith({"stress": "(MPa)", "pressure": "(MPa)", "contact": "(mm)"}[colour])
    page.wait_for_function("document.querySelector('.dome-note').textContent === ''")
    assert colours(page) > 50


def test_two_designs_are_compared(page, link, designs):
    open_page(page, link, "?depth=3&design=1")
    choose(page, "second-design", designs[0])
    page.wait_for_function("document.querySelectorAll('.camera-view')[1].querySelectorAll('circle').length > 0")
    assert page.locator(".dome-view:visible").count() == 2
    page.wait_for_function("Number(document.querySelectorAll('.dome-view')[1].dataset.drawn) > 0")
    assert page.get_by_test_id("figures").locator("tr").first.inner_text().count("H20") == 2


def test_a_note_is_beside_the_buttons_of_the_views(page, link):
    page.goto(link + "?design=1&other=0")
    page.wait_for_function(DRAWN)
    buttons = page.locator(".views").bounding_box()
    for note in page.locator(".dome-note").all():
        note.evaluate("note => note.textContent = 'Reading the presses …'")
        assert note.bounding_box()["y"] >= buttons["y"] + buttons["height"]


def test_compared_designs_have_one_scale_and_one_range_of_colours(page, link, designs):
    open_page(page, link, "?depth=3&design=1")
    alone = scale(page, 0)
    choose(page, "second-design", designs[0])
    page.wait_for_function("document.querySelectorAll('.camera-view')[1].querySelectorAll('circle').length > 0")
    page.wait_for_function(f"Number(document.querySelector('.dome-gauge').dataset.pxPerMm) < 0.8 * {alone}")
    assert scale(page, 0) == pytest.approx(scale(page, 1), rel=1e-3)
    page.evaluate(
        """import('palpate-stage').then(({ stage, changed }) => {
        const { motion } = stage.slots.b; motion.arrays.displacement.forEach((v, i, all) => (all[i] = 2 * v));
        delete motion.tops; changed(); })"""
    )
    high = [page.locator(".dome-legend span:last-of-type").nth(i) for i in (0, 1)]
    page.wait_for_function("Number(document.querySelector('.dome-legend span:last-of-type').textContent) > 6")
    assert high[0].inner_text() == high[1].inner_text()
    top = page.get_by_role("button", name="top", exact=True)
    assert top.count() == 1
    drawn = [int(page.locator(".dome-view").nth(i).get_attribute("data-drawn")) for i in (0, 1)]
    top.click()
    for i in (0, 1):
        page.wait_for_function(f"Number(document.querySelectorAll('.dome-view')[{i}].dataset.drawn) > {drawn[i]}")


def scale(page, pane):
    """Pixels of the page in a mm of a 3-D view."""
    return float(page.locator(".dome-gauge").nth(pane).get_attribute("data-px-per-mm"))


def test_the_bar_of_the_scale_is_as_long_as_it_states(page, link):
    open_page(page, link, "?depth=2")
    gauge = page.locator(".dome-gauge").first
    words = gauge.locator("text.scale").text_content()
    assert words.endswith(" mm")
    bar = gauge.locator("path.scale").evaluate("e => e.getBBox().width")
    assert bar == pytest.approx(float(words.split()[0]) * scale(page, 0), abs=0.5)
    assert [text.strip() for text in gauge.locator("g text").all_text_contents()] == ["x", "y", "z"]


def test_the_value_under_the_pointer_is_that_of_the_colour(page, link):
    open_page(page, link, "?depth=3&wall=1")
    before = int(page.locator(".dome-view").first.get_attribute("data-drawn"))
    page.get_by_role("button", name="top", exact=True).click()
    page.wait_for_function(f"Number(document.querySelector('.dome-view').dataset.drawn) > {before}")
    box = page.locator(".dome-view canvas").first.bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2 + 2, box["y"] + box["height"] / 2)
    page.wait_for_function("document.querySelector('.dome-probe').textContent.endsWith(' mm')")
    apex = float(page.locator(".dome-probe").first.inner_text().removesuffix(" mm"))
    assert apex == pytest.approx(3.0, rel=0.05), "the apex moves with the wall"
    page.mouse.move(box["x"] + 4, box["y"] + box["height"] - 4)
    page.wait_for_function("document.querySelector('.dome-probe').textContent === ''")


AREA = """async () => {
    const [{ placeSection }, { stage }, { THREE }] = await Promise.all(
        ["palpate-stage/section.js", "palpate-stage", "nicegui-scene"].map(name => import(name)));
    const { shell } = stage.slots.a; const count = shell.arrays.rest.length;
    const three = { section: new THREE.Mesh(), skin: {}, positions: { array: shell.arrays.rest },
        colours: { array: new Float32Array(count) }, field: new Float32Array(count / 3) };
    placeSection(three, shell);
    const points = three.section.geometry.getAttribute("position").array; let area = 0;
    const corner = i => new THREE.Vector3(points[i], points[i + 1], points[i + 2]);
    for (let i = 0; i < points.length; i += 9)
        area += new THREE.Triangle(corner(i), corner(i + 3), corner(i + 6)).getArea();
    return area; }"""


def test_the_cut_is_moved_and_its_face_is_whole(page, link):
    open_page(page, link)
    for at in (0, 6, -12.5):
        slide(page, "cut_at", at)
        # of a hemisphere, half a ring whose area is the same in every plane
        assert page.evaluate(AREA) == pytest.approx(math.pi / 2 * (22**2 - 20**2), rel=0.02)
    page.wait_for_url(re.compile("cut_at=-12.5"))
    page.get_by_role("checkbox", name="Cut away").click()
    page.wait_for_function("!document.querySelector('.pose-bar input[name=cut_at]')")


def test_a_resting_picture_has_more_pixels_than_the_screen(page, link):
    open_page(page, link)
    page.wait_for_function(
        "(c => c.width >= 1.4 * c.clientWidth)(document.querySelector('.dome-view canvas')) || devicePixelRatio > 1"
    )


def test_no_colour_is_shown_before_the_stress_is_there(page, link):
    open_page(page, link, "?depth=3&trails=0")
    held = []
    page.route("**/data/motion/*field=stress*", lambda route: held.append(route))
    page.get_by_test_id("colour").get_by_role("button", name="stress", exact=True).click()
    page.wait_for_function("document.querySelector('.dome-note').textContent !== ''")
    legend = page.locator(".dome-legend span:last-of-type").first
    assert legend.inner_text() == "…"
    assert most_yellow(page) < 12
    page.wait_for_timeout(100)
    held[0].continue_()
    page.wait_for_function("document.querySelector('.dome-note').textContent === ''")
    assert float(legend.inner_text()) > 0
    assert most_yellow(page) > 40


def most_yellow(page):
    """The greatest excess of green over blue in the 3-D picture."""
    return page.evaluate(
        """() => { const c = document.querySelector('.dome-view canvas'); const d = document.createElement('canvas');
        d.width = c.width; d.height = c.height; const x = d.getContext('2d'); x.drawImage(c, 0, 0);
        const p = x.getImageData(0, 0, c.width, c.height).data; let most = 0;
        for (let i = 0; i < p.length; i += 4) if (p[i + 3] > 250) most = Math.max(most, p[i + 1] - p[i + 2]);
        return most; }"""
    )


@pytest.mark.parametrize("query", ["", "?design=1&other=0"], ids=["one", "compared"])
def test_the_page_fits_a_phone(page, link, query):
    page.set_viewport_size({"width": 390, "height": 844})
    open_page(page, link, query)
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    head = page.locator(".head").bounding_box()
    for icon in page.locator(".head .q-icon").all():
        box = icon.bounding_box()
        assert box["y"] >= 0
        assert box["y"] + box["height"] <= head["height"]
        assert box["x"] + box["width"] <= 390


def test_selects_and_axes_are_read_in_whole(page, link):
    open_page(page, link)
    page.locator(".heat svg text").first.wait_for()
    for name in ("metric", "across", "up"):
        assert page.get_by_test_id(name).evaluate("e => e.scrollWidth - e.clientWidth") <= 0, name
    texts = page.locator(".heat svg text").evaluate_all(
        "all => all.map(e => [e.textContent, e.getBoundingClientRect().left, e.getBoundingClientRect().right])"
    )
    label = next(right for text, _, right in texts if text == "H (mm)")
    tick = min(left for text, left, _ in texts if text == "20")
    assert tick - label >= 2
    page.get_by_test_id("metric").hover()
    page.locator(".q-tooltip", has_text=page.get_by_test_id("metric").input_value()).wait_for()


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
    ("press.zip", b"PK"),
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
