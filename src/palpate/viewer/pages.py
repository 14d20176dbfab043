"""Application with all pages of the viewer."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from fastapi import FastAPI, Request
from nicegui import ui

from palpate.core import PalpateError
from palpate.fea import Press
from palpate.optimise import SearchFolder
from palpate.surrogate import Twin
from palpate.viewer.design_cache import DesignCache
from palpate.viewer.design_page import DesignPage
from palpate.viewer.explore_page import ExplorePage
from palpate.viewer.library import DesignLibrary
from palpate.viewer.live_opening import DesignOpening, LiveOpening, TrainedOpening
from palpate.viewer.live_page import LivePage
from palpate.viewer.opened_results import OpenedResult, OpenedResults
from palpate.viewer.page_head import PageHeader, error_label, show_error
from palpate.viewer.results_page import show_press, show_results, show_twin
from palpate.viewer.routes import answer_errors, make_routes
from palpate.viewer.search_page import SearchPage
from palpate.viewer.trained import TrainedSensor
from palpate.viewer.trained_page import TrainedPage

TITLE = "palpate"


def build_app(path: Path | None) -> FastAPI:
    """Return the application for a result or a folder of results; its pages report unreadable ones."""
    results = OpenedResults(path)
    shelf = results.shelf
    app = FastAPI(title=TITLE, docs_url=None, redoc_url=None, openapi_url=None)
    answer_errors(app)
    app.include_router(make_routes(shelf, results.sensors))

    @ui.page("/", title=TITLE)
    def explore(request: Request) -> None:
        show_page(results, request, "/", lambda found: show_result(found, shelf, request))

    @ui.page("/design", title=f"{TITLE}: design")
    def design(request: Request) -> None:
        DesignPage(shelf, request).build()

    @ui.page("/live", title=f"{TITLE}: live")
    def live(request: Request) -> None:
        show_page(results, request, "/live", lambda found: LivePage(read_live(found), request).build())

    ui.run_with(app, title=TITLE, tailwind=False, show_welcome_message=False, language="en-US")
    return app


def show_page(results: OpenedResults, request: Request, here: str, show: Callable[[OpenedResult], None]) -> None:
    """Show the result that a request names, or the list; or the reason why it cannot be opened."""
    name = request.query_params.get("result", "")
    if results.path is not None and not name and "" not in (found := results.find()):
        show_results(results.path, found, request, here)
        return
    try:
        show(results.open(name))
    except PalpateError as error:
        show_reason(request, here, error)


def show_result(found: OpenedResult, shelf: DesignCache, request: Request) -> None:
    """Show the page of an opened result."""
    match found:
        case SearchFolder():
            SearchPage(found, shelf, request).build()
        case TrainedSensor():
            TrainedPage(found, request).build()
        case Press():
            show_press(found, shelf, request)
        case Twin():
            show_twin(found, request)
        case _:
            ExplorePage(found, request).build()


def read_live(found: OpenedResult) -> LiveOpening:
    """Return the selection of a sensor that an opened result reads.

    Raises
    ------
    PalpateError
        If it has no trained model.
    """
    if isinstance(found, TrainedSensor):
        return TrainedOpening(found)
    if isinstance(found, DesignLibrary):
        return DesignOpening(found)
    raise PalpateError(
        "Only a study or a model of a recording reads a sensor.", "Open one of them instead.", code="model-missing"
    )


def show_reason(request: Request, here: str, reason: PalpateError) -> None:
    """Show a page without results: reason and remedy."""
    PageHeader(request, here, "no results")
    with ui.element("div").classes("empty"):
        show_error(error_label(), str(reason), reason.code)
        ui.label(
            "Make results with `palpate run studies/first.yaml`, then open them with `palpate view results/first`."
        )
        ui.link("Design a dome and press it now", "/design").classes("go").props('data-testid="to-design"')
