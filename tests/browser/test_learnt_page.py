"""A sensor that was learnt from a recording, looked at and read on the page."""

from collections.abc import Iterator

import pytest
from viewer_process import viewer

from errors import check_values
from presses import copy_learnt_sensor


@pytest.fixture(scope="module")
def learnt_link(tmp_path_factory) -> Iterator[str]:
    """The viewer on a folder of palpate recording train, with the recording below it."""
    with viewer(copy_learnt_sensor(tmp_path_factory.mktemp("learnt"))) as address:
        yield address


def test_the_report_is_shown_and_images_are_read(page, learnt_link):
    page.goto(learnt_link)
    assert page.locator("table.errors tr").count() >= 3
    page.locator(".report .card img").first.wait_for()
    page.set_viewport_size({"width": 390, "height": 800})
    assert page.locator(".report .card .q-img").first.bounding_box()["width"] >= 700, (
        "wide enough to read, in a scroller"
    )
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
    page.set_viewport_size({"width": 1280, "height": 800})
    assert {"RMSE rx (°)", "maximum rx (°)"} <= set(page.locator("table.errors th").all_inner_texts())
    page.goto(learnt_link + "live")
    page.get_by_test_id("start").click()
    page.locator("[data-testid=status][data-found='61'][data-markers='61']").wait_for()
    check_values(page.get_by_test_id("status").inner_text(), 61)
    page.wait_for_function("document.querySelectorAll('.figures td').length >= 12")
    page.set_viewport_size({"width": 390, "height": 800})
    assert page.evaluate("document.documentElement.scrollWidth") <= 390
