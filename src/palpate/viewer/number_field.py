"""A number on the page: a slider and a box, with the bounds and unit that its spec declares."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from nicegui import events, ui
from pydantic import BaseModel

from palpate.core import parameters
from palpate.viewer.sketch import bounds_of

Change = Callable[[float], None]
WRONG_FIELD = "wrong-field"
"""Marker of the labels that state the error of a field; empty without one."""


class NumberField:
    """One number of a spec.

    Parameters
    ----------
    spec, name
        The spec and its field.
    label
        Name on the page.
    step
        Step of the slider.
    change
        Called with each new value that is within the bounds.
    ends
        Minimum and maximum on the page; by default the bounds.
    """

    def __init__(
        self,
        spec: type[BaseModel],
        name: str,
        label: str,
        step: float,
        change: Change,
        ends: tuple[float, float] | None = None,
    ) -> None:
        note = next(note for note in parameters(spec) if note.name == name)
        low, high = ends or bounds_of(spec, name)
        unit = {"deg": "°", "1": ""}.get(note.unit, note.unit)
        self._place(f"{label} ({unit})" if unit else label, (low, high, step), float(note.default), change, name)
        self._row.props(f'title="{note.meaning}"')

    @classmethod
    def free(
        cls, name: str, label: str, ends: tuple[float, float, float], value: float, change: Change
    ) -> NumberField:
        """Make a field for a number without a spec, from its minimum, maximum and step."""
        field = cls.__new__(cls)
        field._place(label, ends, value, change, name)
        return field

    def note(self, text: str) -> None:
        """Add a note to the number."""
        with self._row:
            ui.label(text).classes("faint field-note")

    def put(self, value: float) -> None:
        """Set a value as a visitor does: the callback is called."""
        self._box.value = value

    def _place(self, label: str, ends: tuple[float, float, float], value: float, change: Change, name: str) -> None:
        place = f"field-{name.replace('_', '-')}"
        self._low, self._high, step = ends
        self._change = change
        with ui.element("div").classes("field") as self._row:
            ui.label(label).classes("field-name")
            self._slider = ui.slider(min=self._low, max=self._high, step=step, value=value)
            self._slider.props(f'dense aria-label="{label}"').on_value_change(self._slide)
            self._box = ui.number(value=value, step=step, on_change=self._type).props(
                f'dense borderless hide-bottom-space aria-label="{label}" data-testid="{place}"'
            )
            self._wrong = ui.label("").mark(WRONG_FIELD).classes("field-wrong")
            self._wrong.props(f'role="alert" data-testid="{place}-wrong"')

    def _slide(self, event: events.ValueChangeEventArguments[Any]) -> None:
        if event.value is not None and event.value != self._box.value:
            self._box.value = round(float(event.value), 6)

    def _type(self, event: events.ValueChangeEventArguments[Any]) -> None:
        value = event.value
        if not isinstance(value, int | float) or not math.isfinite(value):
            self._wrong.text = "This is no number."
        elif not self._low <= value <= self._high:
            self._wrong.text = f"From {self._low:g} to {self._high:g}."
        else:
            self._wrong.text = ""
            if self._slider.value != value:
                self._slider.value = value
            self._change(float(value))
