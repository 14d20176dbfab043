"""Design page: a skin set by sliders, pressed by the solver, and exported as a fabrication pack."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from fastapi import Request
from nicegui import events, ui

from palpate.camera import CameraSpec, camera_preset, list_presets
from palpate.design import DomeSpec, MarkerSpec, markers_in_rings
from palpate.material import list_materials
from palpate.viewer.design_cache import DesignCache
from palpate.viewer.number_field import NumberField
from palpate.viewer.page_head import PageHeader, heading
from palpate.viewer.sketch import DesignDraft
from palpate.viewer.workbench import Workbench

_RINGS = 8
"""Maximum number of rings of the slider."""
_DOME = (("height", "Height H", 0.5), ("base_radius", "Base radius B", 0.5), ("thickness", "Thickness T", 0.1))


class DesignPage:
    """Design of one visitor.

    Parameters
    ----------
    shelf
        Cache from which the browser requests the design.
    request
        Request of the page.
    """

    def __init__(self, shelf: DesignCache, request: Request) -> None:
        self._chosen: dict[str, dict[str, Any]] = {part: {} for part in DesignDraft.model_fields}
        self._rings = 7
        self._bench = Workbench(shelf, PageHeader(request, "/design", "a design of your own"))

    def build(self) -> None:
        """Place every element and draw the first sketch."""
        with ui.element("div").classes("explorer"):
            with ui.element("section").classes("side").props('aria-label="Design"'):
                self._build_fields()
            with ui.element("section").classes("stage").props('aria-label="Dome"'):
                self._bench.build_stage()
            with ui.element("section").classes("side").props('aria-label="Camera and force"'):
                self._bench.build_right()
        self._redraw()

    def _build_fields(self) -> None:
        with ui.element("div").classes("card"):
            heading("Dome")
            for name, label, step in _DOME:
                NumberField(DomeSpec, name, label, step, self._setter("skin", name))
            ui.select(
                list(list_materials()),
                value=DesignDraft().material.name,
                label="Elastomer",
                on_change=lambda event: self._set("material", "name", event.value),
            ).props("dense outlined options-dense").classes("wide material")
        with ui.element("div").classes("card"):
            heading("Markers")
            self._ring_count = NumberField.free("rings", "Rings", (0, _RINGS, 1), self._rings, self._set_rings)
            self._ring_count.note("a marker at the apex, 6 k on ring k")
            self._own_rings = ui.input(
                "Diameters of the rings, mm",
                placeholder="even; or your own: 6, 14, 25",
                on_change=lambda event: self._set_diameters(event.value),
            ).props('dense outlined debounce=500 stack-label data-testid="ring-diameters"')
            self._own_rings.classes("wide")
            NumberField(MarkerSpec, "diameter", "Dot", 0.1, self._setter("markers", "diameter"), (0.1, 4.0))
        with ui.element("div").classes("card"):
            heading("Camera")
            ui.select(
                list(list_presets()), value=list_presets()[0], label="Camera", on_change=self._set_camera
            ).props("dense outlined options-dense").classes("wide")
            NumberField(
                CameraSpec, "distance", "Below the base", 1.0, self._setter("camera", "distance"), (10.0, 150.0)
            )
        self._bench.build_wall(lambda name, value: self._set("obstacle", name, value))

    def _setter(self, part: str, name: str) -> Callable[[float], None]:
        return lambda value: self._set(part, name, value)

    def _set_rings(self, rings: float) -> None:
        """Set this many evenly spaced rings."""
        self._rings = int(rings)
        if len(_words(self._own_rings.value)) != self._rings:
            self._own_rings.set_value("")
            self._set_diameters("")

    def _set_diameters(self, text: str | None) -> None:
        """Set ring diameters, from the apex outward, and the slider; an empty field spaces the rings evenly."""
        words = _words(text)
        if 0 < len(words) <= _RINGS:
            self._ring_count.put(len(words))
        self._chosen["markers"]["ring_diameters"] = words or None
        self._set("markers", "count", markers_in_rings(len(words) or self._rings))

    def _set_camera(self, event: events.ValueChangeEventArguments[Any]) -> None:
        distance = self._chosen["camera"].get("distance")
        self._chosen["camera"] = camera_preset(event.value).model_dump()
        if distance is not None:
            self._chosen["camera"]["distance"] = distance
        self._redraw()

    def _set(self, part: str, name: str, value: Any) -> None:
        self._chosen[part][name] = value
        self._redraw()

    def _redraw(self) -> None:
        self._bench.show(self._chosen)


def _words(text: str | None) -> list[str]:
    return (text or "").replace(",", " ").split()
