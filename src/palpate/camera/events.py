"""Events of a press, as an event camera such as a DAVIS sends them in addition to its images.

A pixel stores a level M of the logarithm L of its light. Whenever L differs from it by the threshold C, the pixel
sends an event with the sign of the change, and M moves by one threshold. Between two images L is linear in time, so

    t = t_0 + (t_1 - t_0) (M ± k C - L_0) / (L_1 - L_0),      k = 1 … floor(|L_1 - M| / C)

(pixel model: Lichtsteiner, Posch and Delbruck, *IEEE J. Solid-State Circuits* 43 (2008) 566). Each pixel has its own
threshold, and sends no two events within its dead time.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import BoolArray, FloatArray, IntArray, PalpateError, Spec, generator, parameter


class EventSpec(Spec):
    """Properties of the pixels of an event camera."""

    threshold: float = parameter(0.15, unit="1", meaning="change of log light that makes an event", gt=0.01, le=2)
    spread: float = parameter(
        0.03, unit="1", meaning="relative standard deviation of the threshold between pixels", ge=0, le=0.3
    )
    dark: float = parameter(2.0, unit="1", meaning="grey level added to the light, that of the dark current", gt=0)
    dead_time: float = parameter(
        0.0, unit="s", meaning="time after an event without further events of its pixel", ge=0, le=1
    )
    seed: int = parameter(0, unit="1", meaning="seed of the thresholds", ge=0)


@dataclass(frozen=True, eq=False)
class Events:
    """Events between two images, in order of time.

    Attributes
    ----------
    time
        (n,) s.
    column, row
        (n,) pixel.
    brighter
        (n,) whether the pixel got brighter.
    """

    time: FloatArray
    column: IntArray
    row: IntArray
    brighter: BoolArray

    def __len__(self) -> int:
        return len(self.time)


def stream_events(
    images: Iterable[NDArray[Any]], times: Iterable[float], spec: EventSpec | None = None
) -> Iterator[Events]:
    """Yield the events between successive images; render these without noise, which would give events too.

    Parameters
    ----------
    images
        (h, w) grey levels, all of one size.
    times
        Time of each image, s, ascending.
    spec
        The pixels.

    Raises
    ------
    PalpateError
        If an image has another size, or the times are not ascending.
    """
    spec = spec or EventSpec()
    nothing: FloatArray = np.empty((0, 0))
    remembered, threshold, last, light, before = nothing, nothing, nothing, nothing, 0.0
    for image, time in zip(images, times, strict=True):
        now = np.log(np.asarray(image, float) + spec.dark)
        if not remembered.size:
            rng = generator(spec.seed, "threshold")
            threshold = spec.threshold * np.maximum(1.0 + spec.spread * rng.normal(size=now.shape), 0.1)
            remembered, light, last = now.copy(), now, np.full(now.shape, -np.inf)
        elif now.shape != light.shape or time <= before:
            raise PalpateError(
                f"An image of {now.shape[1]} × {now.shape[0]} px at {time:g} s follows one of {light.shape[1]} × "
                f"{light.shape[0]} px at {before:g} s.",
                "Give images of one size at ascending times.",
                code="events-image-order",
            )
        else:
            found, remembered = _between((light, now), (before, time), remembered, threshold)
            yield _without_blind(found, last, spec.dead_time)
        light, before = now, time


def _between(
    light: tuple[FloatArray, FloatArray], times: tuple[float, float], remembered: FloatArray, step: FloatArray
) -> tuple[Events, FloatArray]:
    """Return the events between two images, with linear log light, and the new levels of the pixels."""
    start, end = light
    gathered = end - remembered
    counts = np.floor(np.abs(gathered) / step).astype(int)
    rows, columns = np.nonzero(counts)
    many = counts[rows, columns]
    which = np.repeat(np.arange(len(rows)), many)
    order = np.arange(len(which)) - np.repeat(np.cumsum(many) - many, many) + 1
    row, column = rows[which], columns[which]
    sign = np.sign(gathered[row, column])
    level = remembered[row, column] + sign * order * step[row, column]
    share = (level - start[row, column]) / (end - start)[row, column]
    time = times[0] + (times[1] - times[0]) * np.clip(share, 0.0, 1.0)
    after = np.argsort(time, kind="stable")
    events = Events(time[after], column[after], row[after], sign[after] > 0)
    return events, remembered + np.sign(gathered) * counts * step


def _without_blind(events: Events, last: FloatArray, dead_time: float) -> Events:
    """Leave out events within the dead time of their pixel; `last` is updated."""
    if not dead_time:
        return events
    keep = np.zeros(len(events), bool)
    for number, (time, row, column) in enumerate(zip(events.time, events.row, events.column, strict=True)):
        if time - last[row, column] >= dead_time:
            keep[number], last[row, column] = True, time
    return Events(events.time[keep], events.column[keep], events.row[keep], events.brighter[keep])
