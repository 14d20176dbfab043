"""Sensor with a model that was trained on a recording, without a design."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import PalpateError
from palpate.learn import PoseReading, RecordedModel
from palpate.sensor.reading import Flag, Reading
from palpate.sensor.spec import SensorSpec
from palpate.vision import TrackedMarkers


class RecordedSensor:
    """Sensor with a model of `palpate recording train`; it reads each image on its own, in any order."""

    def __init__(self, model: RecordedModel, spec: SensorSpec | None = None) -> None:
        self.model, self.spec = model, spec or SensorSpec()
        self._count = 0

    def read(self, image: NDArray[Any] | PalpateError) -> Reading:
        """Estimate the pose in the next image; an error instead of an image gives a flagged reading."""
        start, space = time.perf_counter(), self.model.space
        self._count += 1
        try:
            if isinstance(image, PalpateError):
                raise image
            found = self.model.read(image)
            return self._describe(found, start)
        except Exception as error:  # a sensor at work outlives whatever one image does to a library
            none, anything = (float("nan"),) * len(space.names), (float("inf"),) * len(space.names)
            latency = (time.perf_counter() - start) * 1e3
            return Reading(
                self._count,
                none,
                anything,
                False,
                0,
                (Flag.UNREADABLE,),
                latency,
                PalpateError.of(error).problem,
                space=space,
            )

    def _describe(self, found: PoseReading, start: float) -> Reading:
        flags = [] if not found.fault else [Flag.FEW_MARKERS if np.isnan(found.pose).any() else Flag.IMAGE_ONLY]
        outside = np.isfinite(found.pose).all() and self.model.is_outside(found.pose, found.half_width)
        if found.unlike or outside:
            flags.append(Flag.OUT_OF_DISTRIBUTION)
        seen = found.correspondence
        moved = np.inf if seen is None or found.fault else float(np.sqrt(np.mean(seen.moved_px**2)))
        return Reading(
            image=self._count,
            pose=tuple(found.pose.tolist()),
            half_width=tuple(found.half_width.tolist()),
            touching=moved > self.spec.touch_px,
            found=found.found,
            flags=tuple(flags),
            latency_ms=(time.perf_counter() - start) * 1e3,
            reason=found.fault,
            sighting=self._sighting(found),
            space=self.model.space,
        )

    def _sighting(self, found: PoseReading) -> TrackedMarkers | None:
        """Return the positions of the assigned markers; `None` if the assignment was not accepted."""
        seen, layout = found.correspondence, self.model.layout
        if seen is None or layout is None or not seen.accepted:
            return None
        places = layout.rest_px + seen.moved_px
        blob = np.linalg.norm(places[:, None] - found.dots_px[None], axis=-1).argmin(axis=1)
        return TrackedMarkers(places, seen.found, np.where(seen.found, blob, -1), False)
