"""Screenshots of every page in both sizes and lights, for people to look at; nothing may overflow."""

import pytest
from walk import DRAWN


@pytest.mark.slow
@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
@pytest.mark.parametrize("size", [(1280, 800), (1920, 1080)], ids=["1280x800", "1920x1080"])
def test_pages_fit_the_screen(page, link, pictures, size, dark):
    page.set_viewport_size({"width": size[0], "height": size[1]})
    page.context.add_cookies([{"name": "palpate_dark", "value": str(int(dark)), "url": link}])
    name = f"{size[0]}x{size[1]}_{'dark' if dark else 'light'}"
    places = {"explore": "?depth=3.4&tilt=5&azimuth=30", "compare": "?depth=3&design=1&other=0", "design": "design"}
    for title, query in {**places, "live": "live"}.items():
        page.goto(link + query)
        if title == "live":
            page.get_by_test_id("start").click()
            page.wait_for_function("Number(document.querySelector('.live-view svg').dataset.shown) > 6")
        else:
            page.wait_for_function(DRAWN)
        page.wait_for_timeout(400)
        page.screenshot(path=pictures / f"{title}_{name}.png")
        wide, tall = page.evaluate("[document.documentElement.scrollWidth, document.documentElement.scrollHeight]")
        assert wide <= size[0], title
        assert tall <= size[1], title
        assert page.evaluate("document.body.classList.contains('body--dark')") is dark


def test_light_turns_to_dark_and_is_remembered(page, link):
    page.goto(link)
    page.wait_for_function(DRAWN)
    page.get_by_test_id("theme").click()
    page.wait_for_function("document.body.classList.contains('body--dark')")
    page.wait_for_function("document.cookie.includes('palpate_dark=1')")
    page.reload()
    page.wait_for_function("document.body.classList.contains('body--dark')")
