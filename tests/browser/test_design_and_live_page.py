"""Designing, pressing, making and sensing on the page."""

import csv
import io
import zipfile
from pathlib import Path

import pytest
from walk import dots, open_page, wait_for_dots, wait_for_motion

from needs import needs


def box(page, label):
    return page.locator(f"input[aria-label='{label}']")


def test_a_slider_changes_the_camera_at_once(page, link):
    open_page(page, link, "design")
    before = dots(page)
    box(page, "Below the base (mm)").fill("80")
    wait_for_motion(page, before, 100, 1)
    box(page, "Rings").fill("2")
    wait_for_dots(page, 19)


def test_rings_may_be_given_by_their_diameters(page, link):
    open_page(page, link, "design")
    rings = page.get_by_label("Diameters of the rings, mm")
    rings.fill("8, 20")
    wait_for_dots(page, 19)
    before = dots(page)
    rings.fill("8, 30")
    wait_for_motion(page, before, 18, 10)
    rings.fill("8, wide")
    page.get_by_role("alert").filter(has_text="valid number").wait_for()
    rings.fill("20, 8")
    page.get_by_role("alert").filter(has_text="do not grow").wait_for()
    rings.fill("")
    wait_for_dots(page, 169)  # the slider's
    rings.fill("8, 20")
    wait_for_dots(page, 19)
    box(page, "Rings").fill("3")
    wait_for_dots(page, 37)
    assert rings.input_value() == ""


WRONG = (
    ("Height H (mm)", "0", "From 2 to 60."),
    ("Height H (mm)", "1e9", "From 2 to 60."),
    ("Thickness T (mm)", "", "This is no number."),
    ("Rings", "99", "From 0 to 8."),
    ("Dot (mm)", "-1", "From 0.1 to 4."),
    ("Below the base (mm)", "5", "From 10 to 150."),
    ("Tilt (°)", "31", "From 0 to 30."),
    ("Depth (mm)", "0", "From 0.5 to 20."),
)


def test_a_number_that_cannot_be_is_answered_at_its_field(page, link):
    open_page(page, link, "design")
    for label, value, output in WRONG:
        right = box(page, label).input_value()
        box(page, label).fill(value)
        page.get_by_role("alert").filter(has_text=output).wait_for()
        box(page, label).fill(right)
        page.wait_for_function("![...document.querySelectorAll('.field-wrong')].some(e => e.textContent)")
    wait_for_dots(page, 169)


def test_findings_say_what_is_wrong(page, link):
    open_page(page, link, "design")
    box(page, "Below the base (mm)").fill("12")
    page.get_by_text("out of the camera's sight").wait_for()


@pytest.mark.slow
def test_a_press_is_solved_and_another_is_cancelled(page, link):
    open_page(page, link, "design")
    box(page, "Depth (mm)").fill("2")
    box(page, "Height H (mm)").fill("12")
    page.get_by_role("button", name="Press", exact=True).click()
    page.get_by_role("button", name="Cancel").click()
    page.get_by_text("Cancelled.").wait_for()
    page.get_by_role("button", name="Press", exact=True).click()
    page.get_by_text("Pressed in").wait_for(timeout=420_000)
    page.wait_for_function(
        "document.querySelector('.pose-bar input[name=depth]').valueAsNumber > 1.9", timeout=60_000
    )
    assert page.get_by_text("2.00 mm").first.is_visible()


@pytest.mark.slow
def test_a_fabrication_pack_is_made(page, link):
    needs("build123d")
    open_page(page, link, "design")
    with page.expect_download(timeout=240_000) as download:
        page.get_by_role("button", name="Make").click()
    with zipfile.ZipFile(Path(download.value.path())) as pack:
        assert {"pack/instructions.pdf", "pack/manifest.json", "pack/mold.step"} <= set(pack.namelist())
        assert pack.testzip() is None


def test_a_recording_is_replayed_with_pose_and_verdict(page, link):
    page.goto(link + "live")
    page.get_by_label("Unit of the design").click()
    page.get_by_role("option").filter(has_text="19 markers").click()
    page.get_by_label("Images").click()
    page.get_by_role("option").filter(has_text="recording").click()
    page.get_by_role("button", name="Start").click()
    page.wait_for_function("Number(document.querySelector('.live-view svg').dataset.shown) > 1")
    page.get_by_role("button", name="Record", exact=True).click()
    page.wait_for_function("['GO', 'NO GO', 'UNSURE'].includes(document.querySelector('.verdict').textContent)")
    assert page.locator(".live-view image").get_attribute("href").startswith("data:image/png")
    page.get_by_text("The recording ended.").wait_for()
    with page.expect_download() as download:
        page.get_by_role("button", name="Save CSV").click()
    rows = list(csv.DictReader(io.StringIO(Path(download.value.path()).read_text())))
    assert len(rows) > 10
    assert all(row["found"] for row in rows)


def test_virtual_touches_run_until_they_are_stopped(page, link):
    page.goto(link + "live")
    page.get_by_role("button", name="Save CSV").click()
    page.get_by_text("Nothing was recorded yet.").wait_for()
    page.get_by_label("Tolerance (°)").fill("99")
    page.get_by_text("From 0.1 to 30.").wait_for()
    page.get_by_role("button", name="Start").click()
    page.wait_for_function("Number(document.querySelector('.live-view svg').dataset.shown) > 2")
    page.get_by_role("button", name="Stop").click()


def test_a_unit_of_another_design_is_refused(page, link):
    page.goto(link + "live")
    page.get_by_label("Unit of the design").click()
    page.get_by_role("option").filter(has_text=", 7 markers").click()
    page.get_by_label("Images").click()
    page.get_by_role("option").filter(has_text="recording").click()
    page.get_by_role("button", name="Start").click()
    page.locator(".complaint:visible").wait_for()
    assert page.get_by_role("button", name="Start").is_enabled()
