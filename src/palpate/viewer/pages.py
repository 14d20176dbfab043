"""Application with all pages of the viewer."""

from __future__ import annotations

from pathlib import Path

from fastapi import FastAPI, Request
from nicegui import ui

from palpate.core import PalpateError
from palpate.optimise import is_search, read_search
from palpate.study import is_grid
from palpate.viewer.design_cache import DesignCache
from palpate.viewer.design_page import DesignPage
from palpate.viewer.explore_page import ExplorePage
from palpate.viewer.library import DesignLibrary
from palpate.viewer.live_opening import DesignOpening, TrainedOpening
from palpate.viewer.live_page import LivePage
from palpate.viewer.page_head import PageHeader, error_label, show_error
from palpate.viewer.results import read_results
from palpate.viewer.routes import answer_errors, make_routes
from palpate.viewer.search_page import SearchPage
from palpate.viewer.trained import is_trained_sensor, read_trained_sensor
from palpate.viewer.trained_page import TrainedPage

TITLE = "palpate"


def build_app(folder: Path | None) -> FastAPI:
    """Return the application for a result folder; without a readable one, its page reports the reason."""
    shelf, learnt = DesignCache(), None
    reason = PalpateError("No result folder was given.", "Give one to `palpate view`.", code="results-missing")
    search = folder if folder is not None and is_search(folder) and not is_grid(folder) else None
    if search is not None:
        reason = PalpateError(
            "A search has no trained model to read a sensor with.", "Open a study instead.", code="model-missing"
        )
    elif folder is not None:
        try:
            if is_trained_sensor(folder):
                learnt = read_trained_sensor(folder)
            else:
                shelf = DesignCache(DesignLibrary(read_results(folder)))
        except PalpateError as error:
            reason = error
    app = FastAPI(title=TITLE, docs_url=None, redoc_url=None, openapi_url=None)
    answer_errors(app)
    app.include_router(make_routes(shelf, learnt))

    @ui.page("/", title=TITLE)
    def explore(request: Request) -> None:
        if search is not None:
            show_search(request, search, shelf)
        elif learnt is not None:
            TrainedPage(learnt, request).build()
        elif shelf.library is None:
            show_reason(request, "/", reason)
        else:
            ExplorePage(shelf.library, request).build()

    @ui.page("/design", title=f"{TITLE}: design")
    def design(request: Request) -> None:
        DesignPage(shelf, request).build()

    @ui.page("/live", title=f"{TITLE}: live")
    def live(request: Request) -> None:
        if learnt is not None:
            LivePage(TrainedOpening(learnt), request).build()
        elif shelf.library is None:
            show_reason(request, "/live", reason)
        else:
            LivePage(DesignOpening(shelf.library), request).build()

    ui.run_with(app, title=TITLE, tailwind=False, show_welcome_message=False, language="en-US")
    return app


def show_search(request: Request, folder: Path, shelf: DesignCache) -> None:
    """Show the page of a search in the present state of its folder."""
    try:
        SearchPage(read_search(folder), shelf, request).build()
    except PalpateError as error:
        show_reason(request, "/", error)


def show_reason(request: Request, here: str, reason: PalpateError) -> None:
    """Show a page without results: reason and remedy."""
    PageHeader(request, here, "no results")
    with ui.element("div").classes("empty"):
        show_error(error_label(), str(reason), reason.code)
        ui.label(
            "Make results with `palpate run studies/first.yaml`, then open them with `palpate view results/first`."
        )
        ui.link("Design a dome and press it now", "/design").classes("go").props('data-testid="to-design"')
