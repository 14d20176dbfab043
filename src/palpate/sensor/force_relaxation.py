"""Force through time: silicone relaxes, so a touch is borne by more force at first than after half a minute.

The twin tells the force of an elastic skin for a pose. Where its material relaxes, the force that is there depends on
when the poses came; it is followed from reading to reading, whatever the rate, with one number a term and direction.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from palpate.calibration import Force
from palpate.material import Relaxation, StressHistory
from palpate.sensor.reading import Reading


class ForceRelaxation:
    """Follows the force of one sensor.

    Readings without a pose are passed over: the force is taken to have run straight between its neighbours, and so
    it is over a stall, where nobody knows when the touch came. Where the clock goes back, a new history begins.

    Parameters
    ----------
    relaxation
        Of the skin.
    """

    def __init__(self, relaxation: Relaxation) -> None:
        self.relaxation = relaxation
        self._history = StressHistory(relaxation)

    def update(self, reading: Reading, time_s: float) -> Reading:
        """The reading of a time in s, with the force that is there then."""
        if reading.force is None or not np.isfinite(reading.force.vector).all():
            return reading
        if self._history.time is not None and time_s < self._history.time:
            self._history = StressHistory(self.relaxation)
        elastic = reading.force.vector if reading.touching else np.zeros(3)
        there = self._history.update(time_s, elastic)
        return replace(reading, force=_replaced(reading.force, there)) if reading.touching else reading


def _replaced(elastic: Force, there: np.ndarray) -> Force:
    """A force with another vector (3,) N; a skin that is let go of faster than it recovers does not pull."""
    size = float(np.linalg.norm(elastic.vector))
    if there @ elastic.normal < 0:
        there = np.zeros(3)
    share = float(np.linalg.norm(there)) / size if size > 0 else 1.0
    return replace(elastic, vector=there, covariance=share**2 * elastic.covariance)
