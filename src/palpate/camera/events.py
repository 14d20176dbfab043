"""Events of a press, as an event camera such as a DAVIS would send them beside its images.

A pixel remembers a level M of the logarithm L of its light. Whenever L has moved from it by the threshold C, it sends
an event of the sign of the motion, and M is one step further. Between two images L moves evenly in time, so that

    t = t_0 + (t_1 - t_0) (M ± k C - L_0) / (L_1 - L_0),      k = 1 … floor(|L_1 - M| / C)

(Lichtsteiner, Posch and Delbruck, *IEEE J. Solid-State Circuits* 43 (2008) 566, for the pixel). Each pixel has a
threshold of its own, and sends no two events within its dead time.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import BoolArray, FloatArray, IntArray, PalpateError, Spec, generator, parameter


class EventSpec(Spec):
    """The pixels of an event camera."""

    threshold: float = parameter(0.15, unit="1", meaning="change of log light that makes an event", gt=0.01, le=2)
    spread: float = parameter(
        0.03, unit="1", meaning="standard deviation of the threshold from pixel to pixel, share of it", ge=0, le=0.3
    )
    dark: float = parameter(2.0, unit="1", meaning="grey level added to the light, that of the dark current", gt=0)
    dead_time: float = parameter(0.0, unit="s", meaning="time after an event in which its pixel is blind", ge=0, le=1)
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
        (n,) whether it got brighter.
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
    """Events between every two images; render without noise, a pixel's own noise would be steps.

    Parameters
    ----------
    images
        (h, w) grey levels, all of one size.
    times
        Time of each, s, rising.
    spec
        The pixels.

    Raises
    ------
    PalpateError
        If an image has another size, or the time does not rise.
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
                "Give images of one size at rising times.",
                code="events-image-order",
            )
        else:
            found, remembered = _between((light, now), (before, time), remembered, threshold)
            yield _without_blind(found, last, spec.dead_time)
        light, before = now, time


def _between(
    light: tuple[FloatArray, FloatArray], times: tuple[float, float], remembered: FloatArray, step: FloatArray
) -> tuple[Events, FloatArray]:
    """Events while log light goes evenly from one image to the next, and what every pixel remembers then."""
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
    """Leave out events within the dead time of their pixel; `last` is brought up to date."""
    if not dead_time:
        return events
    keep = np.zeros(len(events), bool)
    for number, (time, row, column) in enumerate(zip(events.time, events.row, events.column, strict=True)):
        if time - last[row, column] >= dead_time:
            keep[number], last[row, column] = True, time
    return Events(events.time[keep], events.column[keep], events.row[keep], events.brighter[keep])
