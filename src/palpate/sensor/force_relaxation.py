"""Contact force in time of a skin that relaxes.

The twin gives the force of an elastic skin for a pose. If the material relaxes, the force also depends on the times
of earlier poses. It is tracked from reading to reading, at any rate, with one state per term and direction.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from palpate.calibration import Force
from palpate.material import Relaxation, StressHistory
from palpate.sensor.reading import Reading


class ForceRelaxation:
    """Tracker of the force of one sensor.

    Readings without a pose are skipped: the force is interpolated linearly between their neighbours, also over a
    pause of the images. If the clock goes back, a new history begins.
    """

    def __init__(self, relaxation: Relaxation) -> None:
        self.relaxation = relaxation
        self._history = StressHistory(relaxation)

    def update(self, reading: Reading, time_s: float) -> Reading:
        """Return the reading at a time in s, with the relaxed force."""
        if reading.force is None or not np.isfinite(reading.force.vector).all():
            return reading
        if self._history.time is not None and time_s < self._history.time:
            self._history = StressHistory(self.relaxation)
        elastic = reading.force.vector if reading.touching else np.zeros(3)
        there = self._history.update(time_s, elastic)
        return replace(reading, force=_replaced(reading.force, there)) if reading.touching else reading


def _replaced(elastic: Force, there: np.ndarray) -> Force:
    """Replace the vector (3,) N of a force; a force that would pull becomes zero."""
    size = float(np.linalg.norm(elastic.vector))
    if there @ elastic.normal < 0:
        there = np.zeros(3)
    share = float(np.linalg.norm(there)) / size if size > 0 else 1.0
    return replace(elastic, vector=there, covariance=share**2 * elastic.covariance)
