"""Designing, pressing, making and sensing on the page."""

import csv
import io
import zipfile
from pathlib import Path

import pytest
from walk import (
    choose,
    dots,
    fault,
    numbers,
    open_page,
    wait_for_dots,
    wait_for_motion,
    wait_for_state,
)

from errors import check_values
from needs import needs
from palpate.mechanics import EndReason


def box(page, name):
    return page.get_by_test_id(f"field-{name}")


def test_a_slider_changes_the_camera_at_once(page, link):
    open_page(page, link, "design")
    before = dots(page)
    box(page, "distance").fill("80")
    wait_for_motion(page, before, 100, 1)
    before = dots(page)
    box(page, "height").fill("14")
    wait_for_motion(page, before, 100, 1)
    box(page, "rings").fill("2")
    wait_for_dots(page, 19)


def test_a_field_of_the_press_draws_the_skin_again(page, link):
    open_page(page, link, "design")
    before = int(page.locator(".dome-view").first.get_attribute("data-drawn"))
    box(page, "tilt-deg").fill("10")
    page.wait_for_function(f"Number(document.querySelector('.dome-view').dataset.drawn) > {before}")


def test_rings_may_be_given_by_their_diameters(page, link):
    open_page(page, link, "design")
    rings = page.get_by_test_id("ring-diameters")
    rings.fill("8, 20")
    wait_for_dots(page, 19)
    before = dots(page)
    rings.fill("8, 30")
    wait_for_motion(page, before, 18, 10)
    rings.fill("8, wide")
    check_values(fault(page, "float_parsing"), "ring diameters", 2, "wide")
    assert page.get_by_test_id("press").is_disabled()
    rings.fill("20, 8")
    check_values(fault(page, "rings-not-growing"), 20, 8)
    rings.fill("")
    page.locator("[data-testid=press]:not([disabled])").wait_for()
    even = dots(page)
    assert len(even) == 19, "two rings, evenly spaced"
    rings.fill("8, 20")
    wait_for_motion(page, even, 18, 1)
    assert box(page, "rings").input_value() == "2"
    box(page, "rings").fill("3")
    wait_for_dots(page, 37)
    assert rings.input_value() == ""


WRONG = (
    ("height", "0", [2, 60]),
    ("height", "1e9", [2, 60]),
    ("thickness", "", []),
    ("rings", "99", [0, 8]),
    ("diameter", "-1", [0.1, 4]),
    ("distance", "5", [10, 150]),
    ("tilt-deg", "31", [0, 30]),
    ("depth", "0", [0.5, 20]),
)


def test_a_number_that_cannot_be_is_answered_at_its_field(page, link):
    open_page(page, link, "design")
    for name, value, bounds in WRONG:
        right = box(page, name).input_value()
        box(page, name).fill(value)
        page.locator(f"[data-testid=field-{name}-wrong][role=alert]:visible").wait_for()
        assert numbers(page, f"field-{name}-wrong") == bounds
        for button in ("press", "make"):
            page.locator(f"[data-testid={button}][disabled]").wait_for()
        box(page, name).fill(right)
        page.wait_for_function("![...document.querySelectorAll('.field-wrong')].some(e => e.textContent)")
        page.locator("[data-testid=press]:not([disabled])").wait_for()
    wait_for_dots(page, 169)


def test_findings_say_what_is_wrong(page, link):
    open_page(page, link, "design")
    box(page, "distance").fill("12")
    page.locator("[data-testid=findings] [data-code=markers-out-of-sight]").wait_for()


@pytest.mark.slow
def test_a_press_is_solved_and_another_is_cancelled(page, link):
    open_page(page, link, "design")
    box(page, "depth").fill("2")
    box(page, "height").fill("12")
    page.get_by_test_id("press").click()
    page.get_by_test_id("cancel").click()
    wait_for_state(page, "cancelled")
    page.get_by_test_id("press").click()
    wait_for_state(page, "pressed", timeout=420_000)
    page.wait_for_function(
        "document.querySelector('.pose-bar input[name=depth]').valueAsNumber > 1.9", timeout=60_000
    )
    check_values(page.get_by_test_id("force-note").inner_text(), EndReason.DEPTH_REACHED, "2.00 mm")
    with page.expect_download() as download:
        page.get_by_test_id("vtk").click()
    assert "press/press.pvd" in zipfile.ZipFile(Path(download.value.path())).namelist()
    box(page, "height").fill("13")
    page.get_by_test_id("vtk").wait_for(state="hidden")


@pytest.mark.slow
def test_a_fabrication_pack_is_made(page, link):
    needs("build123d")
    open_page(page, link, "design")
    with page.expect_download(timeout=240_000) as download:
        page.get_by_test_id("make").click()
    with zipfile.ZipFile(Path(download.value.path())) as pack:
        assert {"pack/instructions.pdf", "pack/manifest.json", "pack/mold.step"} <= set(pack.namelist())
        assert pack.testzip() is None


def test_a_recording_is_replayed_with_pose_and_verdict(page, link, designs):
    page.goto(link + "live")
    choose(page, "unit", designs[1])
    choose(page, "source", "recording")
    page.get_by_test_id("start").click()
    page.wait_for_function("Number(document.querySelector('.live-view svg').dataset.shown) > 1")
    page.get_by_test_id("record").click()
    page.wait_for_function("['go', 'no-go', 'unsure'].includes(document.querySelector('.verdict').dataset.verdict)")
    assert page.locator(".live-view image").get_attribute("href").startswith("data:image/png")
    wait_for_state(page, "ended")
    with page.expect_download() as download:
        page.get_by_test_id("save-readings").click()
    rows = list(csv.DictReader(io.StringIO(Path(download.value.path()).read_text())))
    assert len(rows) > 10
    assert all(row["found"] for row in rows)


def test_virtual_touches_run_until_they_are_stopped(page, link):
    page.goto(link + "live")
    page.get_by_test_id("save-readings").click()
    fault(page, "nothing-recorded")
    page.get_by_test_id("tolerance").fill("99")
    wrong = page.locator(".q-field", has=page.get_by_test_id("tolerance")).locator("[role=alert]")
    wrong.wait_for()
    check_values(wrong.inner_text(), 0.1, 30)
    page.get_by_test_id("start").click()
    page.wait_for_function("Number(document.querySelector('.live-view svg').dataset.shown) > 2")
    page.get_by_test_id("stop").click()


def test_a_unit_of_another_design_is_refused(page, link, designs):
    page.goto(link + "live")
    choose(page, "unit", designs[0])
    choose(page, "source", "recording")
    page.get_by_test_id("start").click()
    page.locator(".complaint:visible").wait_for()
    assert page.get_by_test_id("start").is_enabled()
