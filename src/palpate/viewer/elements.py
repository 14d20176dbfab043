"""Custom elements of the page: skin in 3-D, camera image and pose of the wall, on one stage."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any

from nicegui import ui
from nicegui.element import Element

from palpate.viewer.link import ColourQuantity

SWITCHES = (("cut", "Cut away"), ("markers", "Markers"), ("trails", "Marker paths"), ("wall", "Wall"))
"""Parts of the 3-D view that a visitor shows or hides, with their labels."""


class DomeView(Element, component="scripts/dome_view.js", esm={"palpate-stage": "scripts"}):
    """Skin in 3-D; `slot` is ``"a"`` for the design shown and ``"b"`` for the compared one."""

    def __init__(self, slot: str, label: str) -> None:
        super().__init__()
        self._props["slot-name"] = slot
        self._props["label"] = label

    def look(self, side: str) -> None:
        """Set the view from the ``"side"``, ``"front"``, ``"top"`` or ``"below"``."""
        self.run_method("look", side)

    def save(self, name: str) -> None:
        """Save the view as a PNG file in the browser."""
        self.run_method("savePicture", name)


def view_buttons(*domes: DomeView) -> None:
    """Place buttons that set the direction of all these views."""

    def look(side: str) -> None:
        for dome in domes:
            dome.look(side)

    with ui.element("div").classes("views").props('role="group" aria-label="Look from"'):
        for side in ("side", "front", "top", "below"):
            ui.button(side, on_click=partial(look, side)).props("flat dense no-caps")


def look_row(
    change: Callable[[str, Any], None], first: Mapping[str, Any], switches: Sequence[tuple[str, str]] = SWITCHES
) -> None:
    """Place colour and visible parts of the dome; `change` takes the name and value of one."""
    colours = [str(item) for item in ColourQuantity]
    with ui.element("div").classes("look"):
        ui.toggle(
            colours, value=str(first.get("colour", colours[0])), on_change=lambda event: change("colour", event.value)
        ).props('no-caps dense unelevated role="group" aria-label="Colour of the dome" data-testid="colour"')
        for name, label in switches:
            ui.checkbox(
                label, value=first.get(name, True), on_change=lambda event, name=name: change(name, event.value)
            ).props("dense")


def place_table(
    headings: Sequence[str], rows: Iterable[Sequence[str | Callable[[], object]]], bold: int = -1
) -> None:
    """Place a table of texts, or of elements that are placed by a call; row `bold` is in bold type."""
    with ui.element("div").classes("wide-table"), ui.element("table").classes("errors"):
        with ui.element("tr"):
            for name in headings:
                with ui.element("th"):
                    ui.label(name)
        for number, row in enumerate(rows):
            with ui.element("tr").classes("kept" if number == bold else ""):
                for cell in row:
                    with ui.element("td"):
                        cell() if callable(cell) else ui.label(cell)


class CameraView(Element, component="scripts/camera_view.js"):
    """Image of the camera below the skin; for `slot` see `DomeView`."""

    def __init__(self, slot: str, label: str) -> None:
        super().__init__()
        self._props["slot-name"] = slot
        self._props["label"] = label

    def save(self, name: str) -> None:
        """Save the image as an SVG file in the browser."""
        self.run_method("saveDrawing", name)


class PoseBar(Element, component="scripts/pose_bar.js"):
    """Sliders for depth, tilt, azimuth and cut (mm, degrees); emits ``rest`` with all after a change."""

    def __init__(self, depth: float, tilt: float, azimuth: float, cut_at: float = 0.0) -> None:
        super().__init__()
        self._props["first"] = {"depth": depth, "tilt": tilt, "azimuth": azimuth, "cut_at": cut_at}

    def show(self, name: str | None, slot: str = "a") -> None:
        """Put a design of the shelf on the stage, or take it off."""
        self.run_method("show", name, slot)

    def look(self, **look: Any) -> None:
        """Select the visible parts: `colour`, `cut`, `markers`, `trails`, `wall`."""
        self.run_method("look", look)

    def animate(self, tilt_deg: float, azimuth_deg: float) -> None:
        """Set a pose and animate the press that was put on the stage, as soon as it is loaded."""
        self.run_method("pose", {"depth": 0.0, "tilt": tilt_deg, "azimuth": azimuth_deg})
        self.run_method("playWhenReady")


class LiveView(Element, component="scripts/live_view.js"):
    """An image of a sensor with its markers."""

    def __init__(self, label: str) -> None:
        super().__init__()
        self._props["label"] = label

    def begin(self, width: int, height: int, rest: list[list[float]]) -> None:
        """Prepare for images of a size in px and markers (m, 2) px at rest."""
        self.run_method("begin", width, height, rest)

    def show(self, picture: str, positions: list[list[float]], found: list[bool], stretch: float) -> None:
        """Show an image (a data link) with markers (m, 2) px, whether each was found, and scaled arrows."""
        self.run_method("show", picture, positions, found, stretch)

    def number(self, shown: bool) -> None:
        """Show the markers' numbers, or not."""
        self.run_method("number", shown)
