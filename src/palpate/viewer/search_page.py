"""Page of a search: the front on the left, the selected design on the workbench."""

from __future__ import annotations

from typing import Any

from fastapi import Request
from nicegui import events, ui

from palpate.core import PalpateError
from palpate.optimise import SearchFolder, read_search
from palpate.viewer.design_cache import DesignCache
from palpate.viewer.explore_page import set_chart
from palpate.viewer.front_chart import COLUMNS, design_words, front_chart, role_of
from palpate.viewer.labels import column_label, find_column
from palpate.viewer.page_head import PageHeader, heading
from palpate.viewer.workbench import Workbench

_DEEPEST = 20.0
"""Maximum depth on the page, mm."""
_REFRESH_S = 5.0
"""Time between two looks at the folder of a search that has not finished, s."""


class SearchPage:
    """Search of one visitor.

    Parameters
    ----------
    search
        Contents of the folder.
    shelf
        Cache from which the browser requests designs.
    request
        Request of the page; `design` in its query is the number of the design shown.
    """

    def __init__(self, search: SearchFolder, shelf: DesignCache, request: Request) -> None:
        self._search = search
        self._head = PageHeader(request, "/", f"{search.spec.name} · {search.skins} skins tried")
        self._head.watch(self._draw_front)
        self._bench = Workbench(shelf, self._head)
        self._wall: dict[str, Any] = {}
        asked = request.query_params.get("design", "")
        self._shown = int(asked) if asked.isdecimal() and int(asked) < len(search.rows) else max(search.winner, 0)
        self._across = next((COLUMNS[name] for name in search.spec.objectives if name in COLUMNS), "markers")

    def build(self) -> None:
        """Place every element and show the winner."""
        if not self._search.finished:
            ui.timer(_REFRESH_S, self._follow)
        if not self._search.rows:
            with ui.element("div").classes("empty"):
                ui.label("No skin was evaluated yet. The page shows the first one.").props('role="status"')
            return
        with ui.element("div").classes("explorer search"):
            with ui.element("section").classes("side").props('aria-label="Front"'):
                self._build_front()
            with ui.element("section").classes("stage").props('aria-label="Design"'):
                self._bench.build_stage()
            with ui.element("section").classes("side").props('aria-label="Camera and force"'):
                self._bench.build_right()
        self._wall_fields["depth"].put(min(self._search.spec.depth, _DEEPEST))
        self._draw_front()
        self._show()

    def _follow(self) -> None:
        """Load the page again when the folder has another skin or the results."""
        try:
            found = read_search(self._search.folder)
        except PalpateError:  # the folder is being written; the next look finds it
            return
        if (found.skins, found.finished) != (self._search.skins, self._search.finished):
            ui.navigate.reload()

    def _build_front(self) -> None:
        with ui.element("div").classes("card"):
            heading("The front")
            ui.label(_state(self._search)).classes("faint state").props(
                f'data-testid="search-state" data-finished={str(self._search.finished).lower()}'
            )
            ui.select(
                {column: column_label(column) for column in COLUMNS.values()},
                value=self._across,
                label="Across",
                on_change=self._choose_axis,
            ).props('dense outlined options-dense data-testid="across"').classes("wide across")
            self._chart = ui.echart({}, on_point_click=self._click, renderer="svg").classes("front")
        self._wall_fields = self._bench.build_wall(self._set_wall)
        with ui.element("div").classes("card"):
            heading("Figures")
            self._title = ui.label("").classes("design-title").props('aria-live="polite" data-testid="shown"')
            self._figures = ui.element("table").classes("figures").props('data-testid="figures"')

    def _draw_front(self) -> None:
        if self._search.rows:
            set_chart(self._chart, front_chart(self._search, self._across, self._shown, self._head.ink))

    def _show(self) -> None:
        """Put the selected design on the workbench."""
        self._title.text = design_words(self._search, self._shown)
        self._title.props(f'data-design={self._shown} data-role="{role_of(self._search, self._shown)}"')
        self._figures.clear()
        with self._figures:
            for column, cell in self._search.rows[self._shown].items():
                with ui.element("tr").props(f'data-column="{column}"'):
                    with ui.element("th").props('scope="row"'):
                        ui.label(column_label(column))
                    with ui.element("td"):
                        plain = isinstance(cell, float) and not find_column(column).form
                        ui.label(f"{cell:.6g}" if plain else find_column(column).text(cell))
        self._draw()

    def _draw(self) -> None:
        try:
            found = self._search.design(self._shown)
        except PalpateError as error:
            self._bench.complain(str(error), error.code)
            return
        self._bench.show(
            {
                "skin": found.skin_spec,
                "markers": found.markers,
                "material": {"name": str(self._search.rows[self._shown]["material"])},
                "camera": found.camera_spec,
                "process": self._search.spec.process,
                "obstacle": self._wall,
            }
        )

    def _set_wall(self, name: str, value: Any) -> None:
        if self._wall.get(name) != value:
            self._wall[name] = value
            self._draw()

    def _choose_axis(self, event: events.ValueChangeEventArguments[Any]) -> None:
        if event.value:
            self._across = event.value
            self._draw_front()

    def _click(self, event: events.EChartPointClickEventArguments) -> None:
        value: Any = event.value
        if isinstance(value, list) and len(value) > 2 and int(value[2]) != self._shown:
            self._shown = int(value[2])
            ui.run_javascript(f"history.replaceState(null, '', '{self._head.address('/', design=self._shown)}')")
            self._draw_front()
            self._show()


def _state(search: SearchFolder) -> str:
    """Progress of the search, as a sentence."""
    if not search.finished:
        return (
            f"{search.skins} of {search.spec.skins} skins so far, by coarse presses. The search is running, or was "
            "stopped; new skins appear here."
        )
    found = (
        f"{search.front} design{'s' if search.front > 1 else ''} that none of {search.skins} skins beats"
        if search.front
        else "No design"
    )
    found += f", and {search.coarse} more by coarse presses only" if search.coarse else ""
    return f"{found}; errors are predicted after {search.spec.calibration_presses} calibration presses."
