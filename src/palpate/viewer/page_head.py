"""Header of every page: name, navigation, light and dark theme."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

from fastapi import Request
from nicegui import ui

from palpate.viewer.charts import DARK, FIRST, LIGHT, Theme

STYLE = Path(__file__).parent / "scripts" / "style.css"
COOKIE = "palpate_dark"
PAGES = (("/", "Explore"), ("/design", "Design"), ("/live", "Live"))


class PageHeader:
    """Header of one page.

    Parameters
    ----------
    request
        Request of the page, with the preferred theme; `result` in its query is the name of an opened result.
    here
        Path of this page.
    about
        Subject of the page, e.g. the name of the result folder.
    """

    def __init__(self, request: Request, here: str, about: str) -> None:
        ui.add_css(STYLE)
        ui.colors(primary=FIRST)
        self._dark = ui.dark_mode(request.cookies.get(COOKIE) == "1")
        self._watchers: list[Callable[[], None]] = []
        self._result = request.query_params.get("result", "")
        with ui.element("header").classes("head"):
            ui.link("palpate", "/").classes("wordmark").props('aria-label="palpate, to the explorer"')
            with ui.element("nav").props('aria-label="Pages"'):
                if self._result:
                    ui.link("Results", "/").classes("tab up")
                for path, name in PAGES:
                    link = ui.link(name, self.address(path)).classes("tab")
                    if path == here:
                        link.classes("here").props('aria-current="page"')
            ui.label(about).classes("about").tooltip(about)
            self.tools = ui.element("div").classes("tools")
            self._switch = ui.button(icon=self._icon(), on_click=self._turn).props(
                'flat round dense aria-label="Light or dark" data-testid="theme"'
            )

    def address(self, path: str, **query: Any) -> str:
        """Return the address of a page or file of the opened result."""
        parts = {"result": self._result, **query} if self._result else query
        return f"{path}?{urlencode(parts)}" if parts else path

    @property
    def ink(self) -> Theme:
        """Colours of text and lines in charts."""
        return DARK if self._dark.value else LIGHT

    def watch(self, redraw: Callable[[], None]) -> None:
        """Call `redraw` when the theme changes."""
        self._watchers.append(redraw)

    def _icon(self) -> str:
        return "light_mode" if self._dark.value else "dark_mode"

    def _turn(self) -> None:
        self._dark.value = not self._dark.value
        self._switch.props(f"icon={self._icon()}")
        ui.run_javascript(
            f"document.cookie = '{COOKIE}={int(bool(self._dark.value))}; path=/; max-age=31536000; SameSite=Strict'"
        )
        for redraw in self._watchers:
            redraw()


def show_error(box: ui.label, sentence: str, code: str = "") -> None:
    """Show a message in place, or nothing; `code` is the kind of error, for programs that read the page."""
    box.text = sentence
    box.props(f'data-code="{code}"')
    box.set_visibility(bool(sentence))


def error_label() -> ui.label:
    """Place for an error message; hidden while it is empty."""
    box = ui.label("").classes("complaint").props('role="alert" data-testid="fault"')
    box.set_visibility(False)
    return box


def heading(text: str) -> ui.element:
    """A small heading of a card."""
    with ui.element("h2").classes("card-head") as element:
        ui.label(text)
    return element
