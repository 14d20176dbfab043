"""What can go wrong around the viewer: it is shown in place, and the page stays alive."""

import shutil
import urllib.error
import urllib.request

import pytest
from viewer_process import viewer
from walk import DRAWN, colours, fault, open_page, wait_for_numbers

from errors import check_refusal, check_values
from palpate.cli import main


def test_a_viewer_without_results_says_what_to_do(page, tmp_path):
    (tmp_path / "grid.json").write_text("{}")
    with viewer(tmp_path) as link:
        page.goto(link)
        check_values(fault(page, "grid-unreadable"), tmp_path / "grid.json")
        page.get_by_test_id("to-design").click()
        page.wait_for_function(DRAWN)
        page.goto(link + "live")
        fault(page, "grid-unreadable")
        page.goto("about:blank")


def test_a_broken_press_is_named_and_the_rest_is_shown(page, results, tmp_path):
    broken = tmp_path / "broken"
    shutil.copytree(results, broken)
    press = next((broken / "store" / "press").rglob("*.h5"))
    press.write_bytes(b"no longer a press")
    with viewer(broken) as link:
        page.goto(link)
        sentence = fault(page, "press-unreadable")
        check_values(sentence, press.name)
        page.wait_for_function("Number(document.querySelector('.dome-view').dataset.drawn) > 0")
        assert page.locator("body").inner_text().count(sentence) == 1, "the reason is given once"
        wait_for_numbers(page, "kept", [2, 2])
        page.get_by_test_id("where").fill("markers > 7")
        wait_for_numbers(page, "kept", [1, 2])
        page.goto("about:blank")
    page.faults.clear()  # the browser itself notes the refused request


@pytest.fixture(scope="module")
def guarded(results):
    """A second viewer on the same folder, with a token."""
    with viewer(results, "--token", "0123456789abcdef42") as address:
        yield address


def test_two_viewers_show_one_folder(page, link, guarded):
    assert guarded.partition("?")[0] != link
    for address in (guarded, link):
        open_page(page, address)
        assert colours(page) > 50


def test_a_second_viewer_at_the_same_port_is_refused(link, results, capsys):
    port = link.rstrip("/").rpartition(":")[2]
    with pytest.raises(SystemExit) as left:
        main(["view", str(results), "--port", port])
    assert left.value.code == 2
    check_refusal(capsys.readouterr().err, "port-unavailable", port)


def status(address, **headers):
    try:
        with urllib.request.urlopen(urllib.request.Request(address, headers=headers)) as answer:
            return answer.status
    except urllib.error.HTTPError as error:
        return error.code


@pytest.mark.parametrize(
    "path",
    [
        "data/shell/..%2f..%2fgrid.sqlite",
        "data/shell/%2e%2e/%2e%2e/etc/passwd",
        "../../etc/passwd",
        "_nicegui/../../../etc/passwd",
        "store/press",
        "grid.sqlite",
    ],
)
def test_nothing_outside_the_pages_is_served(link, path):
    assert status(link + path) in (403, 404, 422)


def test_other_pages_and_names_are_refused(link):
    assert status(link) == 200
    assert status(link, Origin="http://evil.example") == 403
    assert status(link, Host="evil.example") == 403
    assert status(link + "_nicegui_ws/socket.io/?EIO=4&transport=websocket", Origin="http://evil.example") == 403


def test_a_token_opens_the_door_once_and_for_all(page, guarded):
    bare = guarded.partition("?")[0]
    assert status(bare) == 401
    open_page(page, guarded)
    assert "token" not in page.url
    open_page(page, bare, "?depth=2")
