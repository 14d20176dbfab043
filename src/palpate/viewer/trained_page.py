"""Page of a sensor trained on a recording: errors of the estimators, and marker assignment."""

from __future__ import annotations

from fastapi import Request
from nicegui import ui

from palpate.viewer.elements import place_table
from palpate.viewer.page_head import PageHeader, heading
from palpate.viewer.trained import PICTURES, TrainedSensor, error_columns, error_rows


class TrainedPage:
    """Report of one visitor.

    Parameters
    ----------
    sensor
        The folder of `palpate recording train`.
    request
        Request of the page.
    """

    def __init__(self, sensor: TrainedSensor, request: Request) -> None:
        self._learnt = sensor
        self._head = PageHeader(request, "/", sensor.folder.resolve().name)

    def build(self) -> None:
        """Place the report."""
        report, about = self._learnt.report, self._learnt.model.about
        with ui.element("div").classes("report"):
            with ui.element("div").classes("card"):
                heading(f"Recording {about['recording']}")
                ui.label(
                    f"{about['images']} images of {about['presses']} presses: {about['train']} for training, "
                    f"{about['validation']} for validation, {about['test']} for the test. No press is in two sets."
                )
                for sentence in [*report.get("notes", []), report.get("enough", "")]:
                    if sentence:
                        ui.label(str(sentence)).classes("faint")
            with ui.element("div").classes("card"):
                heading(f"Errors on the {about['test']} test images; the selected estimator first")
                rows = error_rows(self._learnt)
                place_table(error_columns(self._learnt), rows, 0 if rows[0][0] == report.get("best") else -1)
                ui.link("Read images", self._head.address("/live")).classes("go")
            for name in self._learnt.pictures:
                with ui.element("div").classes("card"):
                    heading(PICTURES[name])
                    with ui.element("div").classes("wide-table"):
                        picture = ui.image(self._head.address(f"/data/learnt/{name}"))
                        picture.props(f'alt="{PICTURES[name]}" fit=contain no-spinner')
