"""Explorer page: grid on the left, pressed skin in the middle, camera and curves on the right."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any
from urllib.parse import urlencode

from fastapi import Request
from nicegui import events, ui

from palpate.core import PalpateError
from palpate.study import design_label, grid_column, own_column
from palpate.viewer.charts import ChartCurve, Selection, heat_chart, line_chart, scatter_chart
from palpate.viewer.curves import error_curves, force_curves
from palpate.viewer.design_panel import DesignPanel
from palpate.viewer.elements import SWITCHES, CameraView, DomeView, PoseBar, look_row, view_buttons
from palpate.viewer.labels import jitter_words
from palpate.viewer.library import DesignLibrary
from palpate.viewer.link import ColourQuantity, first_view, numeric_columns, read_link, selected_rows, write_link
from palpate.viewer.page_head import PageHeader, error_label, heading, show_error
from palpate.viewer.press_download import download_press
from palpate.viewer.pressed_skin import SurfaceMotion
from palpate.viewer.results import GridDesign

_EXAMPLE = "max_error_deg < 2 and height_mm <= 20"


class ExplorePage:
    """Explorer of one visitor.

    Parameters
    ----------
    library
        The result folder.
    request
        Request of the page; its query encodes the view.
    """

    def __init__(self, library: DesignLibrary, request: Request) -> None:
        self._library, self._grid = library, library.results.grid
        self._view, self._complaints = read_link(request.query_params, self._grid)
        self._names = {i: design_label(row) for i, row in enumerate(self._grid.designs)}
        self._head = PageHeader(
            request, "/", f"{library.results.folder.resolve().name} · {len(self._grid.designs)} designs"
        )
        self._head.watch(self._redraw)

    def build(self) -> None:
        """Place every element and show the view."""
        with self._head.tools:
            self._build_export()
        with ui.element("div").classes("explorer"):
            with ui.element("section").classes("side").props('aria-label="Specification grid"'):
                self._build_grid()
                self._build_scatter()
            with ui.element("section").classes("stage").props('aria-label="Pressed dome"'):
                self._build_stage()
            with ui.element("section").classes("side").props('aria-label="Camera and curves"'):
                self._build_curves()
        self._redraw()
        if self._complaints:
            sentences = " ".join((*self._complaints, self._fault.text)).strip()
            show_error(self._fault, sentences, f"link-malformed {self._fault.props.get('data-code', '')}".strip())

    def _build_export(self) -> None:
        ui.button("Link", icon="link", on_click=self._copy_link).props(
            'flat dense no-caps aria-label="Copy the link"'
        )
        with (
            ui.button("Export", icon="download").props(
                'flat dense no-caps aria-label="Export the view" data-testid="export"'
            ),
            ui.menu(),
        ):
            for name, label, save in (
                ("dome-png", "3-D picture (PNG)", lambda: self._dome.save("dome.png")),
                ("camera-svg", "Camera view (SVG)", lambda: self._camera.save("camera.svg")),
                ("heat-maps-svg", "Heat maps (SVG)", self._save_heat),
                ("dome-glb", "Dome at this pose (glTF)", lambda: self._download("dome.glb", depth=self._view.depth)),
                ("press-zip", "Nearest solved press (VTK)", self._download_press),
                ("markers-csv", "Markers at this tilt (CSV)", lambda: self._download("markers.csv")),
                ("grid-csv", "Designs that are kept (CSV)", self._download_grid),
            ):
                ui.menu_item(label, save).props(f'data-testid="export-{name}"')

    def _build_grid(self) -> None:
        columns = {name: grid_column(name).label for name in numeric_columns(self._grid)}
        with ui.element("div").classes("card"):
            heading("Specification grid")
            _select(columns, self._view.metric, "Colour shows", "metric").on_value_change(self._choose_metric)
            self._where = (
                ui.input("Keep designs where", value=self._view.where, placeholder=_EXAMPLE)
                .props('dense outlined clearable debounce=350 data-testid="where"')
                .classes("wide where")
                .on_value_change(self._filter)
            )
            self._kept = ui.label("").classes("faint").props('aria-live="polite" data-testid="kept"')
            self._heat = ui.echart({}, on_point_click=self._click_cell, renderer="svg").classes("heat")
        self._columns = columns

    def _build_scatter(self) -> None:
        with ui.element("div").classes("card"):
            heading("Trade-off")
            for axis, label in (("across", "Across"), ("up", "Up")):
                _select(self._columns, getattr(self._view, axis), label, axis).on_value_change(
                    lambda event, axis=axis: self._choose_axis(axis, event.value)
                )
            self._scatter = ui.echart({}, on_point_click=self._click_dot, renderer="svg").classes("scatter")

    def _build_stage(self) -> None:
        view = self._view
        with ui.element("div").classes("stage-head"):
            self._select = _select(self._names, view.design, "Design", "design")
            self._select.on_value_change(lambda event: self._choose(event.value))
            _select({-1: "nothing", **self._names}, view.other, "Compare with", "second-design").on_value_change(
                lambda event: self._set_second(event.value)
            )
        self._fault = error_label()
        with ui.element("div").classes("domes") as self._domes:
            self._dome = DomeView("a", "Design shown")
            self._second = DomeView("b", "Compared design")
            view_buttons(self._dome, self._second)
        look_row(self._choose_look, asdict(view))
        self._bar = PoseBar(view.depth, view.tilt, view.azimuth, view.cut_at)
        self._bar.on("rest", self._rest)
        self._bar.look(**{name: getattr(view, name) for name, _ in SWITCHES}, colour=str(view.colour))

    def _build_curves(self) -> None:
        with ui.element("div").classes("card"):
            heading("Camera image")
            with ui.element("div").classes("cameras"):
                self._camera = CameraView("a", "Design shown")
                self._camera_second = CameraView("b", "Compared design")
        with ui.element("div").classes("card"):
            heading("Force on the wall (dashed: inverted state)")
            self._force = ui.echart({}, renderer="svg").classes("curve")
            self._force_note = ui.label("").classes("faint")
        with ui.element("div").classes("card"):
            heading(f"Error by depth, {jitter_words(self._grid)} (dashed: least-squares bound)")
            self._error = ui.echart({}, renderer="svg").classes("curve")
        self._panel = DesignPanel()

    def _redraw(self) -> None:
        self._draw_grid()
        self._draw_scatter()
        self._draw_design()

    def _draw_grid(self) -> None:
        chosen, wrong = self._chosen()
        message, total = str(wrong or ""), len(self._grid.designs)
        self._kept.text = message or f"{len(chosen.selected)} of {total} designs kept"
        self._kept.props(f'data-code="{wrong.code if wrong else ""}"')
        self._kept.classes(add="complaint" if message else "faint", remove="faint" if message else "complaint")
        set_chart(self._heat, heat_chart(self._grid, self._view.metric, chosen, self._head.ink))

    def _draw_scatter(self) -> None:
        axes = (self._view.across, self._view.up)
        set_chart(self._scatter, scatter_chart(self._grid, axes, self._chosen()[0], self._head.ink))

    def _chosen(self) -> tuple[Selection, PalpateError | None]:
        """Return highlighted rows, and the error of the query."""
        wrong = None
        try:
            kept = selected_rows(self._grid, self._view.where)
        except PalpateError as error:
            kept, wrong = selected_rows(self._grid, ""), error
        return Selection(kept, self._view.design, self._view.other), wrong

    def _draw_design(self) -> None:
        """Put the selected designs on the stage, with their curves."""
        self._domes.classes(add="two") if self._view.other >= 0 else self._domes.classes(remove="two")
        for element in (self._second, self._camera_second):
            element.set_visibility(self._view.other >= 0)
        self._bar.show(self._name(self._view.design))
        self._bar.show(self._name(self._view.other) if self._view.other >= 0 else None, "b")
        self._draw_curves()

    def _draw_curves(self) -> None:
        designs: list[GridDesign] = []
        shown: list[tuple[GridDesign, SurfaceMotion]] = []
        faults: list[PalpateError] = []
        for number in self._numbers():
            try:
                designs.append(self._library.design(number))
                pressed = self._library.specimen(designs[-1]).pressed
                tilt = min(max(self._view.tilt, pressed.tilts_deg[0]), pressed.tilts_deg[-1])
                shown.append((designs[-1], pressed.at(tilt, self._view.azimuth)))
            except PalpateError as error:
                faults.append(error)
        show_error(self._fault, " ".join(map(str, faults)), " ".join(error.code for error in faults))
        self._panel.show(designs)
        ink, here = self._head.ink, ChartCurve("", [(self._view.depth, 0.0)], self._head.ink.text)
        curves, marks = force_curves(shown)
        self._force.set_visibility(bool(curves))
        set_chart(self._force, line_chart(curves, ("depth (mm)", "force (N)"), ink, [*marks, here]))
        errors = error_curves(self._grid, designs)
        unit = grid_column(own_column(self._grid.columns, "rmse_jitter_deg")).measure
        set_chart(self._error, line_chart(errors, ("depth (mm)", f"RMSE ({unit})"), ink, [here] if errors else []))
        self._force_note.text = " ".join(_end_sentence(*one) for one in shown) or "No press to show."

    def _name(self, number: int) -> str:
        """Name of a design for the cache."""
        return f"{self._view.result}/{number}" if self._view.result else str(number)

    def _numbers(self) -> list[int]:
        return [number for number in (self._view.design, self._view.other) if number >= 0]

    def _change(self, **parts: Any) -> None:
        self._view = replace(self._view, **parts)
        query = write_link(self._view, first_view(self._grid))
        ui.run_javascript(f"history.replaceState(null, '', '/{'?' + query if query else ''}')")

    def _choose(self, number: int | None) -> None:
        if number is None or number == self._view.design:
            return
        self._change(design=number)
        self._select.value = number
        self._redraw()

    def _set_second(self, number: int | None) -> None:
        if number is not None and number != self._view.other:
            self._change(other=number)
            self._redraw()

    def _choose_metric(self, event: events.ValueChangeEventArguments[Any]) -> None:
        if event.value:
            self._change(metric=event.value)
            self._draw_grid()

    def _choose_axis(self, axis: str, column: str | None) -> None:
        if column:
            self._change(**{axis: column})
            self._draw_scatter()

    def _filter(self, event: events.ValueChangeEventArguments[Any]) -> None:
        self._change(where=event.value or "")
        self._draw_grid()
        self._draw_scatter()

    def _click_cell(self, event: events.EChartPointClickEventArguments) -> None:
        self._choose(_row_of(event, 3))

    def _click_dot(self, event: events.EChartPointClickEventArguments) -> None:
        if event.series_type == "scatter":
            self._choose(_row_of(event, 2))

    def _choose_look(self, name: str, value: Any) -> None:
        self._change(**{name: ColourQuantity(value) if name == "colour" else value})
        self._bar.look(**{name: value})

    def _rest(self, event: events.GenericEventArguments) -> None:
        pose = {name: float(event.args[name]) for name in ("depth", "tilt", "azimuth", "cut_at")}
        self._change(**pose)
        self._draw_curves()

    def _copy_link(self) -> None:
        ui.run_javascript("navigator.clipboard.writeText(location.href)")
        ui.notify("The link to this view was copied.", position="top")

    def _save_heat(self) -> None:
        ui.run_javascript(
            f"const svg = getElement({self._heat.id}).$el.querySelector('svg');"
            "const a = document.createElement('a');"
            "a.href = URL.createObjectURL(new Blob([new XMLSerializer().serializeToString(svg)], "
            "{type: 'image/svg+xml'})); a.download = 'heat_maps.svg'; a.click();"
        )

    def _download(self, file: str, **more: float) -> None:
        view = self._view
        query = {"name": self._name(view.design), "tilt": view.tilt, "azimuth": view.azimuth, **more}
        ui.download.from_url(f"/data/{file}?{urlencode(query)}", file)

    async def _download_press(self) -> None:
        try:
            pressed = self._library.specimen(self._library.design(self._view.design)).pressed
        except PalpateError as error:
            show_error(self._fault, str(error), error.code)
            return
        await download_press(pressed.nearest(self._view.tilt, self._view.azimuth), self._fault)

    def _download_grid(self) -> None:
        ui.download.from_url(self._head.address("/data/grid.csv", where=self._view.where), "grid.csv")


def _select(options: dict[Any, str], value: Any, label: str, name: str) -> ui.select:
    """Place a select whose text can be searched; a tooltip shows the whole text of its value."""
    select = ui.select(options, value=value, label=label, with_input=True).classes("wide")
    select.props(f'dense outlined options-dense data-testid="{name}"')
    with select:
        ui.tooltip().bind_text_from(select, "value", lambda chosen: options.get(chosen, ""))
    return select


def set_chart(chart: ui.echart, data: dict[str, Any]) -> None:
    """Replace the data of a chart."""
    chart.options.clear()
    chart.options.update(data)
    chart.update()


def _row_of(event: events.EChartPointClickEventArguments, place: int) -> int | None:
    """Return the row of a clicked point."""
    value: Any = event.value
    return int(value[place]) if isinstance(value, list) and len(value) > place else None


def _end_sentence(design: GridDesign, motion: SurfaceMotion) -> str:
    start = design.row.get("bistable_from_mm")
    second = f" From {start:.2g} mm there is a second, inverted state." if isinstance(start, int | float) else ""
    name, depth = design_label(design.row), motion.depths_mm[-1]
    return f"{name} at {motion.tilt_deg:.3g}° to {depth:.1f} mm: {motion.ended}.{second}"
