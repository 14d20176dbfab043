"""Pages of results without designs to explore: the list of a folder, one press, and one twin."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from pathlib import Path

import numpy as np
from fastapi import Request
from nicegui import ui

from palpate.camera import CameraSpec
from palpate.core import PalpateError
from palpate.design import Design, MarkerLayout
from palpate.fea import Press
from palpate.surrogate import Twin
from palpate.viewer.charts import line_chart
from palpate.viewer.curves import force_curves
from palpate.viewer.design_cache import DesignCache
from palpate.viewer.elements import SWITCHES, DomeView, PoseBar, look_row, place_table, view_buttons
from palpate.viewer.explore_page import set_chart
from palpate.viewer.library import RenderedSkin
from palpate.viewer.opened_results import describe_result
from palpate.viewer.page_head import PageHeader, error_label, heading, show_error
from palpate.viewer.press_download import download_press
from palpate.viewer.pressed_skin import build_pressed_skin
from palpate.viewer.results import GridDesign
from palpate.viewer.shell import build_shell


def show_results(folder: Path, found: Mapping[str, Path], request: Request, here: str) -> None:
    """Show the list of results by their names, the newest first; each opens on the page `here`."""
    head = PageHeader(request, here, f"{folder.resolve().name} · {len(found)} results")
    facts = {name: describe_result(path) for name, path in found.items()}
    rows = [
        (partial(ui.link, name, head.address(here, result=name)), *facts[name])
        for name in sorted(found, key=lambda name: facts[name][-1], reverse=True)
    ]
    with ui.element("div").classes("report"), ui.element("div").classes("card"):
        heading(f"Results in {folder}")
        place_table(("name", "kind", "designs or presses", "date"), rows)


def show_twin(twin: Twin, request: Request) -> None:
    """Show the range and the error of a twin."""
    PageHeader(request, "/", f"twin of {twin.skin.name}")
    inverse = ", ".join(f"{value:g}" for value in twin.inverse_frictions)
    rows = [
        ("skin", twin.skin.name),
        ("tilt", f"0 to {twin.tilts_deg[-1]:g}°"),
        ("depth", f"0 to {twin.max_depth_mm.min():.2f} mm at every tilt and friction"),
        ("inverse friction 1/µ", inverse),
        ("inverted state", "none" if twin.inverted is None else f"from {twin.inverted.depths_mm[0]:.2f} mm"),
        ("interpolation error (RMS)", f"{twin.interpolation_error_mm:.4f} mm"),
        ("omitted derivatives", ", ".join(twin.left_out) or "none"),
    ]
    with ui.element("div").classes("report"), ui.element("div").classes("card"):
        heading(f"Twin of {twin.skin.name}")
        place_table(("", ""), rows)
        ui.label("`palpate sensor live --model` reads the images of a unit by it.").classes("faint")


def show_press(press: Press, shelf: DesignCache, request: Request) -> None:
    """Show one press and its force, or the reason why it is not drawn; with a button for its download."""
    head = PageHeader(request, "/", f"{press.mesh.skin.name}, {press.obstacle.label}")
    bar: PoseBar
    with ui.element("div").classes("explorer press"):
        with ui.element("section").classes("stage").props('aria-label="Pressed dome"'):
            fault = error_label()
            with ui.element("div").classes("domes"):
                view_buttons(DomeView("a", "The press"))
            look_row(lambda name, value: bar.look(**{name: value}), {}, (SWITCHES[0], SWITCHES[-1]))
            bar = PoseBar(0.0, 0.0, 0.0)
        with ui.element("section").classes("side").props('aria-label="Force"'), ui.element("div").classes("card"):
            heading("Force on the wall (dashed: inverted state)")
            force = ui.echart({}, renderer="svg").classes("curve")
            ui.label(f"Ended: {press.ended} at {press.ended_depth:.2f} mm.").classes("faint")
    with head.tools:
        ui.button("Export", icon="download", on_click=lambda: download_press(press, fault)).props(
            'flat dense no-caps aria-label="Download the press for ParaView" data-testid="export"'
        )
    try:
        pressed = build_pressed_skin([press])
    except PalpateError as error:
        show_error(fault, str(error), error.code)
        force.set_visibility(False)
        return
    layout = MarkerLayout(np.zeros((0, 3)), 1.0)  # a press has no markers
    design = Design.of_skin(press.mesh.skin, layout, CameraSpec(), press.material)
    shown = GridDesign(0, {}, design, ())
    bar.show(shelf.put(shown, RenderedSkin(pressed, build_shell(pressed.mesh))))
    tilt, azimuth = press.obstacle.radial, press.obstacle.turn_deg % 360
    bar.animate(tilt, azimuth)
    curves, _ = force_curves([(shown, pressed.at(tilt, azimuth))])

    def draw() -> None:
        set_chart(force, line_chart(curves, ("depth (mm)", "force (N)"), head.ink))

    head.watch(draw)
    draw()
