"""A tiny study, the viewer on its results as a process of its own, and a browser that looks at it."""

import os
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import cv2
import pytest
from viewer_process import viewer

from needs import find_program, needs, needs_program
from palpate.sensor import Unit
from palpate.simulation import SimulatedSource, sample_presses
from palpate.study import design_label
from palpate.viewer.library import DesignLibrary
from palpate.viewer.results import read_results
from presses import run_tiny_study

CHROMIUM = find_program("chromium")
FLAGS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
FLAGS += ["--disable-gpu-compositing"]  # pages without software GL, as Chrome draws them where there is no GPU
PATIENCE_MS = 60_000


def pytest_collection_modifyitems(items):
    here = Path(__file__).parent
    for item in (item for item in items if here in item.path.parents):
        item.add_marker(needs_program("chromium"))


@pytest.fixture(scope="session", autouse=True)
def _what_the_browser_needs():
    for module in ("playwright", "nicegui", "torch"):
        needs(module)


@pytest.fixture(scope="session")
def results(tmp_path_factory) -> Path:
    """Results of a real study, and a recording of virtual touches of its second design inside them."""
    out = run_tiny_study(tmp_path_factory.mktemp("viewer") / "results")
    library = DesignLibrary(read_results(out))
    design = library.design(1)
    recording = out / "recording"
    recording.mkdir()
    unit = Unit(design.design)
    touches = SimulatedSource(unit, sample_presses(library.specimen(design).pressed.solved, seed=2))
    for number, image in enumerate(islice(touches.images(), 30)):
        cv2.imwrite(str(recording / f"{number:03d}.png"), image)
    return out


@pytest.fixture(scope="session")
def designs(results) -> list[str]:
    """Names of the designs of the study, as fields offer them."""
    return [design_label(row) for row in read_results(results).grid.designs]


@pytest.fixture(scope="session")
def link(results) -> Iterator[str]:
    with viewer(results) as address:
        yield address


@pytest.fixture(scope="session")
def chromium():
    api = needs("playwright.sync_api")
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def context(chromium):
    """Shared by all tests, so that the pages' scripts are read and compiled once."""
    return chromium.new_context(viewport={"width": 1024, "height": 640}, accept_downloads=True)


@pytest.fixture
def page(context):
    """A page without cookies, whose every fault fails the test, and which asks nobody but this machine."""
    context.clear_cookies()
    page = context.new_page()
    page.set_default_timeout(PATIENCE_MS)
    faults: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda message: faults.append(message.text) if message.type == "error" else None)
    page.on("request", lambda request: None if _is_ours(request.url) else faults.append(f"asked {request.url}"))
    page.faults = faults
    yield page
    page.close()
    assert faults == []


def _is_ours(address: str) -> bool:
    return address.startswith(("http://127.0.0.1:", "ws://127.0.0.1:", "data:", "blob:", "about:"))


@pytest.fixture(scope="session")
def pictures(tmp_path_factory) -> Path:
    """Where screenshots are kept: the folder that PALPATE_SCREENSHOTS names, for people to look at."""
    folder = os.environ.get("PALPATE_SCREENSHOTS")
    path = Path(folder) if folder else tmp_path_factory.mktemp("screenshots")
    path.mkdir(parents=True, exist_ok=True)
    return path
