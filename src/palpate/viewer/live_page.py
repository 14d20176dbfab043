"""Live page: images of a unit, markers, pose of the wall, and comparison with a tolerance."""

from __future__ import annotations

import asyncio
import base64
from typing import Any

import numpy as np
from fastapi import Request
from nicegui import events, ui
from numpy.typing import NDArray

from palpate.core import PalpateError, load_opencv
from palpate.core.report import csv_text
from palpate.sensor import Reading
from palpate.viewer.dial import COLOURS, draw_dial
from palpate.viewer.elements import LiveView
from palpate.viewer.live import Live, LiveImage, LiveVerdict, rate_reading, tilt_interval
from palpate.viewer.live_opening import LiveOpening
from palpate.viewer.page_head import PageHeader, error_label, heading, show_error

_PERIOD_S = 0.1


class LivePage:
    """Sensor of one visitor.

    Parameters
    ----------
    opening
        Selection of the sensor.
    request
        Request of the page.
    """

    def __init__(self, opening: LiveOpening, request: Request) -> None:
        self._opening = opening
        self._live: Live | None = None
        self._busy = False
        self._tolerance = 2.0
        self._kept: list[dict[str, Any]] = []
        PageHeader(request, "/live", opening.folder.resolve().name)

    def build(self) -> None:
        """Place every element; nothing runs before *Start*."""
        with ui.element("div").classes("live"):
            with ui.element("section").classes("side").props('aria-label="Source"'):
                self._build_source()
                self._build_record()
            with ui.element("section").classes("stage").props('aria-label="Image"'):
                self._fault = error_label()
                self._view = LiveView("The sensor's image with its markers")
                self._status = ui.label("").classes("faint")
                self._status.props('role="status" data-testid="status" data-state="idle"')
            with ui.element("section").classes("side").props('aria-label="Pose"'):
                self._build_pose()
        self._timer = ui.timer(_PERIOD_S, self._next, active=False)
        self._show_pose(None)

    def _build_source(self) -> None:
        with ui.element("div").classes("card"):
            heading("Source")
            self._opening.build()
            with ui.element("div").classes("do"):
                self._start_button = ui.button("Start", icon="play_arrow", on_click=self._start)
                self._start_button.props('no-caps unelevated dense data-testid="start"')
                ui.button("Stop", icon="stop", on_click=self._stop).props('no-caps outline dense data-testid="stop"')

    def _build_record(self) -> None:
        with ui.element("div").classes("card"):
            heading("Record")
            with ui.element("div").classes("do"):
                self._record = ui.button("Record", icon="fiber_manual_record", on_click=self._turn_record)
                self._record.props('no-caps outline dense data-testid="record"')
                ui.button("Save CSV", icon="download", on_click=self._save).props(
                    'no-caps flat dense data-testid="save-readings"'
                )
            self._recorded = ui.label("Nothing recorded.").classes("faint").props('aria-live="polite"')
        with ui.element("div").classes("card"):
            heading("Picture")
            ui.checkbox("Numbers of the markers", on_change=lambda event: self._view.number(event.value)).props(
                "dense"
            )
            self._stretch = ui.number("Arrows, times", value=2.0, min=0.5, max=20, step=0.5).props("dense outlined")

    def _build_pose(self) -> None:
        with ui.element("div").classes("card"):
            heading("Pose of the wall")
            self._verdict = ui.label("").classes("verdict").props('role="status" data-testid="verdict"')
            self._dial = ui.html("", sanitize=False).classes("dial-box")
            self._figures = ui.element("table").classes("figures").props('data-testid="figures"')
        with ui.element("div").classes("card"):
            heading("Upright to within")
            self._limit = ui.number(
                "Tolerance (°)",
                value=self._tolerance,
                step=0.5,
                validation={"From 0.1 to 30.": lambda value: value is not None and 0.1 <= value <= 30},
                on_change=self._set_tolerance,
            ).props('dense outlined data-testid="tolerance"')

    async def _start(self) -> None:
        self._stop()
        show_error(self._fault, "")
        self._show_state("opening", "Opening the sensor …")
        try:
            self._live = await asyncio.to_thread(self._opening.open)
        except PalpateError as error:
            self._show_state("idle", "")
            show_error(self._fault, str(error), error.code)
            return
        height, width = self._live.size_px
        self._view.begin(width, height, self._live.rest_px.round(2).tolist())
        self._timer.activate()

    def _stop(self) -> None:
        self._timer.deactivate()
        live, self._live = self._live, None
        if live is not None:
            live.close()
        self._record.text = "Record"

    async def _next(self) -> None:
        live = self._live
        if live is None or self._busy:
            return
        self._busy = True
        try:
            step = await asyncio.to_thread(live.step)
        except PalpateError as error:
            self._stop()
            self._show_state("failed", self._status.text)
            show_error(self._fault, str(error), error.code)
            return
        finally:
            self._busy = False
        if live is not self._live:
            return
        if step is None:
            self._stop()
            self._show_state("ended", "The recording ended.")
            return
        self._show(step)

    def _show(self, step: LiveImage) -> None:
        picture = "" if step.image is None else _as_link(step.image)
        stretch = min(max(float(self._stretch.value or 1.0), 0.5), 20.0)
        self._view.show(picture, step.positions_px.round(2).tolist(), step.found.tolist(), stretch)
        reading = step.reading
        found = f"Image {reading.image}: {reading.found} of {len(step.found)} markers found"
        parts = (found, f"{reading.latency_ms:.0f} ms", "; ".join(reading.flags), reading.reason)
        self._show_state("running", " · ".join(part for part in parts if part))
        self._status.props(f"data-found={reading.found} data-markers={len(step.found)}")
        self._show_pose(step)
        record = self._live.record if self._live else None
        if record is not None:
            self._recorded.text = f"{len(record)} readings recorded."

    def _show_pose(self, step: LiveImage | None) -> None:
        reading = step.reading if step else None
        verdict = rate_reading(reading, self._tolerance) if reading else LiveVerdict.NO_TOUCH
        self._verdict.text = verdict.upper()
        self._verdict.props(f'data-verdict="{verdict.replace(" ", "-")}"')
        self._verdict.style(f"background: {COLOURS[verdict]}")
        known = step.truth if step else None
        self._dial.set_content(draw_dial(reading, self._tolerance, verdict, known, self._opening.reach_deg))
        self._figures.clear()
        if step is None or verdict is LiveVerdict.NO_TOUCH:
            return
        with self._figures:
            for name, value, half, unit, truth in list_figures(step.reading, step.truth):
                with ui.element("tr"):
                    for text in (name, f"{value:.2f} ± {half:.2f} {unit}", truth):
                        with ui.element("td"):
                            ui.label(text)

    def _show_state(self, state: str, what: str) -> None:
        self._status.text = what
        self._status.props(f'data-state="{state}"')

    def _set_tolerance(self, event: events.ValueChangeEventArguments[Any]) -> None:
        if isinstance(event.value, int | float) and 0.1 <= event.value <= 30:
            self._tolerance = float(event.value)

    def _turn_record(self) -> None:
        if self._live is None:
            show_error(self._fault, "Nothing runs yet: start a source first.", "nothing-running")
            return
        show_error(self._fault, "")
        self._live.record = [] if self._live.record is None else None
        on = self._live.record is not None
        self._record.text = "Stop recording" if on else "Record"
        self._kept = self._live.record if self._live.record is not None else self._kept

    def _save(self) -> None:
        if not self._kept:
            show_error(self._fault, "Nothing was recorded yet.", "nothing-recorded")
            return
        ui.download.content(csv_text(self._kept), "readings.csv")


def list_figures(reading: Reading, truth: tuple[float, ...] | None) -> list[tuple[str, float, float, str, str]]:
    """Return rows of the table next to the dial: name, value, half-width, unit, and note."""
    least, most = tilt_interval(reading)
    rows = [
        (item.axis, value, half, item.unit_symbol.strip(), f"true {truth[i]:.2f}{item.unit_symbol}" if truth else "")
        for i, (item, value, half) in enumerate(
            zip(reading.space.components, reading.pose, reading.half_width, strict=True)
        )
    ]
    if reading.space.is_tilt:
        rows.append(("tilt", reading.radial, (most - least) / 2, "°", f"{least:.2f}° to {most:.2f}°"))
    if reading.force is not None:
        force = reading.force
        rows += [
            ("force", force.normal_force.value, force.normal_force.half_width, "N", "along the wall's normal"),
            ("sideways", force.tangential_force.value, force.tangential_force.half_width, "N", "in the wall's plane"),
        ]
    if reading.fit is not None:
        spread = np.sqrt(np.diag(reading.fit.covariance))
        correlation = float(reading.fit.covariance[0, 1] / (spread[0] * spread[1]))
        state = "; the skin is inverted" if reading.fit.inverted else ""
        slip, bend = reading.fit.inverse_friction, reading.fit.curvature
        rows += [
            ("1/µ", slip.value, slip.half_width, "", "0 does not slip"),
            *([("1/R", bend.value, bend.half_width, "/m", "0 is flat")] if bend.sd else []),
            ("misfit", reading.fit.misfit, 0.0, "", f"about 1; rx and ry correlate by {correlation:+.2f}{state}"),
        ]
    return rows


def _as_link(image: NDArray[np.uint8]) -> str:
    """Return an image (h, w) as a data link, as PNG."""
    png = load_opencv().imencode(".png", image)[1]
    return "data:image/png;base64," + base64.b64encode(png).decode()
