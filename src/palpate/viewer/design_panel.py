"""The figures of one or two designs, side by side."""

from __future__ import annotations

from collections.abc import Sequence

from nicegui import ui

from palpate.study import MAIN_COLUMNS, grid_column
from palpate.viewer.page_head import heading
from palpate.viewer.results import GridDesign


class DesignPanel:
    """A card with the main figures of the designs shown."""

    def __init__(self) -> None:
        with ui.element("div").classes("card"):
            heading("Figures")
            self._table = ui.element("table").classes("figures").props('data-testid="figures"')

    def show(self, designs: Sequence[GridDesign]) -> None:
        """Show the figures of these designs, a column each."""
        self._table.clear()
        with self._table:
            if len(designs) > 1:
                self._row("", [design.name for design in designs], "th")
            for column in MAIN_COLUMNS:
                if any(column in design.row for design in designs):
                    shown = grid_column(column)
                    self._row(shown.label, [shown.text(design.row.get(column)) for design in designs])
            failures = [str(design.row.get("failure") or "") for design in designs]
            if any(failures):
                self._row("failure", failures)

    def _row(self, name: str, cells: Sequence[str], kind: str = "td") -> None:
        with ui.element("tr"):
            with ui.element("th").props('scope="row"'):
                ui.label(name)
            for cell in cells:
                with ui.element(kind):
                    ui.label(cell)
