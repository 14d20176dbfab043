"""Sensor with a model that was trained on a recording, without a design."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import PalpateError
from palpate.learn import RecordedModel
from palpate.sensor.reading import Flag, Reading
from palpate.sensor.spec import SensorSpec
from palpate.vision import Correspondence, MatchFault, TrackedMarkers


class RecordedSensor:
    """Sensor with a model of `palpate recording train`; it reads each image on its own, in any order."""

    def __init__(self, model: RecordedModel, spec: SensorSpec | None = None) -> None:
        self.model, self.spec = model, spec or SensorSpec()
        self._count = 0

    def read(self, image: NDArray[Any] | PalpateError) -> Reading:
        """Estimate the pose in the next image; an error instead of an image gives a flagged reading."""
        start = time.perf_counter()
        self._count += 1
        try:
            if isinstance(image, PalpateError):
                raise image
            reading = self._read(image)
        except Exception as error:  # a sensor at work outlives whatever one image does to a library
            reading = Reading.without_pose(self.model.space, Flag.UNREADABLE, reason=PalpateError.of(error).problem)
        return replace(reading, image=self._count, latency_ms=(time.perf_counter() - start) * 1e3)

    def _read(self, image: NDArray[Any]) -> Reading:
        estimate, seen = self.model.read(image)
        pose, half_width = estimate.pose[0], estimate.half_width[0]
        fault = "" if seen is None else str(seen.fault)
        flags = [] if not fault else [Flag.FEW_MARKERS if np.isnan(pose).any() else Flag.IMAGE_ONLY]
        outside = np.isfinite(pose).all() and self.model.is_outside(pose, half_width)
        if estimate.out_of_distribution[0] or outside:
            flags.append(Flag.OUT_OF_DISTRIBUTION)
        moved = np.inf if seen is None or fault else float(np.sqrt(np.mean(seen.moved_px**2)))
        return Reading(
            pose=pose,
            half_width=half_width,
            touching=moved > self.spec.touch_px,
            flags=tuple(flags),
            found=0 if seen is None else int(seen.found.sum()),
            reason=fault,
            sighting=self._sighting(seen),
            space=self.model.space,
        )

    def _sighting(self, seen: Correspondence | None) -> TrackedMarkers | None:
        """Return the positions of the assigned markers; `None` if they could not be assigned."""
        if seen is None or self.model.layout is None or seen.fault not in (MatchFault.NONE, MatchFault.PICTURE):
            return None
        return TrackedMarkers(self.model.layout.rest_px + seen.moved_px, seen.found, seen.blob, False)
