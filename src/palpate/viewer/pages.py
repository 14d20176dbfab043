"""All pages of the viewer put together as one application."""

from __future__ import annotations

from pathlib import Path

from fastapi import FastAPI, Request
from nicegui import ui

from palpate.core import PalpateError
from palpate.grid import is_grid
from palpate.optimise import is_search, read_search
from palpate.viewer.design_page import DesignPage
from palpate.viewer.explore_page import ExplorePage
from palpate.viewer.learnt import is_learnt, read_learnt
from palpate.viewer.learnt_page import LearntPage
from palpate.viewer.library import Library
from palpate.viewer.live_opening import DesignOpening, LearntOpening
from palpate.viewer.live_page import LivePage
from palpate.viewer.page_head import Head, complain, complaint
from palpate.viewer.results import read_results
from palpate.viewer.routes import answer_errors, make_routes
from palpate.viewer.search_page import SearchPage
from palpate.viewer.specimen_cache import SpecimenCache

TITLE = "palpate"


def build_app(folder: Path | None) -> FastAPI:
    """The application for a result folder; without one, or with one that cannot be read, its page says so."""
    shelf, learnt = SpecimenCache(), None
    reason = PalpateError("No result folder was given.", "Give one to `palpate view`.", code="results-missing")
    search = folder if folder is not None and is_search(folder) and not is_grid(folder) else None
    if search is not None:
        reason = PalpateError(
            "A search has no trained model to read a sensor with.", "Open a study instead.", code="model-missing"
        )
    elif folder is not None:
        try:
            if is_learnt(folder):
                learnt = read_learnt(folder)
            else:
                shelf = SpecimenCache(Library(read_results(folder)))
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
            LearntPage(learnt, request).build()
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
            LivePage(LearntOpening(learnt), request).build()
        elif shelf.library is None:
            show_reason(request, "/live", reason)
        else:
            LivePage(DesignOpening(shelf.library), request).build()

    ui.run_with(app, title=TITLE, tailwind=False, show_welcome_message=False, language="en-US")
    return app


def show_search(request: Request, folder: Path, shelf: SpecimenCache) -> None:
    """The page of a search as its folder is now; a search that runs has found more when it is loaded again."""
    try:
        SearchPage(read_search(folder), shelf, request).build()
    except PalpateError as error:
        show_reason(request, "/", error)


def show_reason(request: Request, here: str, reason: PalpateError) -> None:
    """A page without results: why, and what to do."""
    Head(request, here, "no results")
    with ui.element("div").classes("empty"):
        complain(complaint(), str(reason), reason.code)
        ui.label(
            "Make results with `palpate run studies/first.yaml`, then open them with `palpate view results/first`."
        )
        ui.link("Design a dome and press it now", "/design").classes("go").props('data-testid="to-design"')
