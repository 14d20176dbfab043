"""Workbench: a draft on the stage, pressed by the solver, and exported as a fabrication pack.

The design page shows the design of its fields on it, the page of a search the selected design.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from nicegui import ElementFilter, ui
from pydantic import ValidationError

from palpate.core import PalpateError, Spec
from palpate.core.run import LocalWorkers, Progress
from palpate.design import Finding
from palpate.fea import Press, WallSpec
from palpate.viewer.charts import ChartCurve, line_chart
from palpate.viewer.curves import force_curves
from palpate.viewer.design_cache import DesignCache
from palpate.viewer.elements import CameraView, DomeView, PoseBar, look_row, view_buttons
from palpate.viewer.explore_page import set_chart
from palpate.viewer.library import RenderedSkin
from palpate.viewer.number_field import WRONG_FIELD, NumberField
from palpate.viewer.page_head import PageHeader, error_label, heading, show_error
from palpate.viewer.press_download import download_press
from palpate.viewer.pressed_skin import build_pressed_skin
from palpate.viewer.shell import build_shell
from palpate.viewer.sketch import DesignDraft, build_preview
from palpate.viewer.work import pack_sketch, press_sketch

_LOOK_S = 0.2
_CONTACTS = ("no-slip", "frictionless")
_WALL = (("tilt_deg", "Tilt", 0.5), ("azimuth_deg", "Azimuth", 5.0), ("depth", "Depth", 0.5))


class Workbench:
    """Workbench of one visitor.

    Parameters
    ----------
    shelf
        Cache from which the browser requests the design.
    head
        Header of the page.
    """

    def __init__(self, shelf: DesignCache, head: PageHeader) -> None:
        self._shelf, self._head = shelf, head
        self._sketch = DesignDraft()
        self._drawn = build_preview(self._sketch)
        self._ordered = (self._sketch, self._drawn)
        self._pool: LocalWorkers | None = None
        self._done, self._what, self._cancelled = Progress(), "", False
        self._valid = True
        self._finish: Callable[[Any], None] = self._show_press
        self._curves: list[ChartCurve] = []
        self._solved: Press | None = None
        head.watch(self._draw_force)

    def build_wall(self, change: Callable[[str, Any], None]) -> dict[str, NumberField]:
        """Place the fields of the press; `change` takes the name and the value of a number of `WallSpec`."""
        fields = {}
        with ui.element("div").classes("card"):
            heading("Press")
            for name, label, step in _WALL:
                ends = {"depth": (0.5, 20.0), "azimuth_deg": (0.0, 360.0)}.get(name)
                fields[name] = NumberField(WallSpec, name, label, step, partial(change, name), ends)
            ui.select(
                list(_CONTACTS),
                value=self._sketch.obstacle.contact,
                label="Contact",
                on_change=lambda event: change("contact", event.value),
            ).props("dense outlined options-dense").classes("wide contact")
        return fields

    def build_stage(self) -> None:
        """Place the dome, its buttons and the bar of its pose."""
        with ui.element("div").classes("do"):
            self._press = ui.button("Press", icon="compress", on_click=self._start_press).props(
                'no-caps unelevated dense data-testid="press"'
            )
            self._make = ui.button("Make", icon="precision_manufacturing", on_click=self._start_pack)
            self._make.props('no-caps outline dense data-testid="make"')
            self._vtk = ui.button("VTK", icon="download", on_click=self._download_press)
            self._vtk.props('no-caps outline dense aria-label="Download the press for ParaView" data-testid="vtk"')
            self._cancel = ui.button("Cancel", on_click=self._cancel_job)
            self._cancel.props('no-caps flat dense data-testid="cancel"')
            self._progress = ui.linear_progress(0.0, show_value=False).props('aria-label="Progress"').classes("grow")
            self._status = ui.label("").classes("faint status").props('role="status" data-testid="status"')
        self._wrong = list(ElementFilter(kind=ui.label, marker=WRONG_FIELD))
        for button in (self._press, self._make):
            for label in self._wrong:
                button.bind_enabled_from(label, "text", lambda _: self._ready())
        self._fault = error_label()
        with ui.element("div").classes("domes"):
            view_buttons(DomeView("a", "The design"))
        look_row(lambda name, value: self._bar.look(**{name: value}), {})
        self._bar = PoseBar(0.0, 0.0, 0.0)
        self._busy(False)
        self._timer = ui.timer(_LOOK_S, self._look, active=False)
        ui.context.client.on_disconnect(self._cancel_job)

    def build_right(self) -> None:
        """Place the camera's view, findings and the force."""
        with ui.element("div").classes("card"):
            heading("Camera image")
            CameraView("a", "The design")
        with ui.element("div").classes("card"):
            heading("Findings")
            self._findings = ui.element("ul").classes("findings").props('data-testid="findings"')
        with ui.element("div").classes("card"):
            heading("Force on the wall")
            self._force = ui.echart({}, renderer="svg").classes("curve")
            self._force_note = ui.label("Not pressed yet.").classes("faint").props('data-testid="force-note"')

    def show(self, chosen: Mapping[str, Any]) -> None:
        """Draw the draft of these parts at rest; an error is reported and keeps the previous drawing."""
        try:
            self._sketch = DesignDraft.model_validate(chosen)
            self._drawn = build_preview(self._sketch)
        except (PalpateError, ValidationError) as error:
            self._valid = False
            self._enable()
            self.complain(_describe(error), code_of(error))
            return
        self._valid = True
        self._curves, self._solved = [], None
        self._enable()
        self.complain("")
        self._show_findings(self._drawn.findings)
        self._bar.show(self._shelf.put(self._drawn.design, self._drawn.specimen))
        self._force_note.text = "Not pressed yet."
        self._draw_force()

    def complain(self, sentence: str, code: str = "") -> None:
        """Show an error message in place, or nothing; `code` names the kind of error."""
        show_error(self._fault, sentence, code)

    def _show_findings(self, findings: tuple[Finding, ...]) -> None:
        self._findings.clear()
        with self._findings:
            for finding in findings:
                with ui.element("li").classes(str(finding.severity)).props(f'data-code="{finding.code}"'):
                    ui.label(f"{finding.message} {finding.remedy}")
            if not findings:
                with ui.element("li"):
                    ui.label("No finding.")

    def _draw_force(self) -> None:
        self._force.set_visibility(bool(self._curves))
        set_chart(self._force, line_chart(self._curves, ("depth (mm)", "force (N)"), self._head.ink))

    def _show_state(self, state: str, what: str = "") -> None:
        self._status.text = what
        self._status.props(f'data-state="{state}"')

    def _busy(self, busy: bool, what: str = "") -> None:
        self._enable()
        for element in (self._cancel, self._progress):
            element.set_visibility(busy)
        self._show_state("busy" if busy else "idle", what)

    def _ready(self) -> bool:
        """Whether a job can start: none runs, and no field has a wrong value."""
        return self._valid and self._pool is None and not any(label.text for label in self._wrong)

    def _enable(self) -> None:
        for button in (self._press, self._make):
            button.set_enabled(self._ready())
        self._vtk.set_visibility(self._solved is not None)

    def _start_press(self) -> None:
        self._finish = self._show_press
        self._start(press_sketch, "Pressing …")

    def _start_pack(self) -> None:
        self._finish = self._hand_out_pack
        self._start(pack_sketch, "Making the fabrication pack …")

    def _start(self, work: Callable[..., Any], what: str) -> None:
        if self._pool is not None:
            return
        show_error(self._fault, "")
        self._ordered = (self._sketch, self._drawn)
        self._pool, self._done, self._what, self._cancelled = LocalWorkers(1), Progress(), what, False
        self._pool.submit(work, self._sketch, progress=self._done)
        self._busy(True, what)
        self._timer.activate()

    def _look(self) -> None:
        if self._pool is None:
            return
        if self._cancelled:
            self._end_work(self._pool)
            self._show_state("cancelled", "Cancelled.")
            return
        ended = self._pool.wait(0.0)
        self._progress.value = self._done.share
        self._status.text = f"{self._what} {self._done.remaining_text}".rstrip()
        for _, outcome in ended:
            self._end_work(self._pool)
            if outcome.reason:
                self._show_state("failed")
                show_error(self._fault, outcome.reason)
            else:
                self._finish(outcome.value)

    def _end_work(self, pool: LocalWorkers) -> None:
        pool.shutdown()
        self._pool = None
        self._timer.deactivate()
        self._busy(False)

    def _cancel_job(self) -> None:
        if self._pool is not None:
            self._cancelled = True
            self._pool.shutdown()  # at once: the visitor may have left, and nothing is shown any more

    async def _download_press(self) -> None:
        if self._solved is not None:
            await download_press(self._solved, self._fault)

    def _show_press(self, press: Press) -> None:
        sketch, drawn = self._ordered
        self._solved = press
        self._enable()
        pressed = build_pressed_skin([press])
        specimen = RenderedSkin(pressed, build_shell(pressed.mesh))
        motion = pressed.at(sketch.obstacle.tilt_deg)
        self._curves, _ = force_curves([(drawn.design, motion)])
        self._force_note.text = press.message or f"Ended: {press.ended} at {press.ended_depth:.2f} mm."
        self._show_state("pressed", f"Pressed in {press.cpu_s:.1f} s.")
        self._draw_force()
        self._bar.show(self._shelf.put(drawn.design, specimen))
        self._bar.animate(sketch.obstacle.tilt_deg, sketch.obstacle.azimuth_deg % 360)

    def _hand_out_pack(self, pack: bytes) -> None:
        self._show_state("made", f"The pack has {len(pack) / 1e6:.1f} MB.")
        ui.download.content(pack, "pack.zip")


def _describe(error: PalpateError | ValidationError) -> str:
    if isinstance(error, PalpateError):
        return str(error)
    return " ".join(f"{Spec.describe_value(item, _name_of(item['loc']))}." for item in error.errors())


def _name_of(place: Sequence[int | str]) -> str:
    """Return the name of a field for a visitor, e.g. ``"ring diameters, value 2,"``."""
    name = next((part.replace("_", " ") for part in reversed(place) if isinstance(part, str)), "")
    return f"{name}, value {place[-1] + 1}," if place and isinstance(place[-1], int) else name


def code_of(error: PalpateError | ValidationError) -> str:
    """Return the code of an error; of a validation error, the type of its first fault."""
    return error.code if isinstance(error, PalpateError) else str(error.errors()[0]["type"])
