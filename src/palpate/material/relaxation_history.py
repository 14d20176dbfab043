"""Relaxed stress or force through time, from its elastic value."""

from __future__ import annotations

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.material.relaxation import Relaxation


class StressHistory:
    """Relaxed stress or force through time, computed from the elastic value of the law.

    Between two times the elastic value is linear, for which the update is exact (Taylor, Pister & Goudreau 1970):
    each term keeps one number, ``h' = exp(-x) h + (1 - exp(-x)) / x Δ`` with ``x`` the time passed over the term's.

    Parameters
    ----------
    relaxation
        Relaxation of the material.

    Examples
    --------
    >>> from palpate.material import Moduli, Relaxation, StressHistory
    >>> history = StressHistory(Relaxation((0.2,), (1.0,), Moduli.INSTANTANEOUS))
    >>> [round(float(history.update(time, 5.0)), 4) for time in (0.0, 1.0, 30.0)]
    [5.0, 4.3679, 4.0]
    """

    def __init__(self, relaxation: Relaxation) -> None:
        self.relaxation = relaxation
        self._shares, self._times = np.array(relaxation.shares), np.array(relaxation.times)
        self._time: float | None = None
        self._elastic: FloatArray = np.zeros(())
        self._parts: FloatArray = np.zeros(len(self._times))

    @property
    def time(self) -> float | None:
        """Time of the last update, s; `None` before the first."""
        return self._time

    def update(self, time: float, elastic: FloatArray | float) -> FloatArray:
        """Advance to a time.

        Parameters
        ----------
        time
            s, not before the last one. The first value is a step at its time, and so is a value at the last time.
        elastic
            Elastic value of the law: a number, or an array (...) of the same shape at every time.

        Returns
        -------
        (...) array
            Relaxed value, in the unit of `elastic`.

        Raises
        ------
        PalpateError
            If time decreases.
        """
        elastic = np.asarray(elastic, float)
        if self._time is None:
            self._elastic, self._parts = np.zeros(elastic.shape), np.zeros((len(self._times), *elastic.shape))
        kept, whole = self._carry(time)
        self._parts = kept + np.multiply.outer(whole, elastic - self._elastic)
        self._time, self._elastic = time, elastic
        return self._sum(elastic, self._parts)

    def affine(self, time: float) -> tuple[FloatArray, float]:
        """Predict the value at a time as ``a + b · elastic``: a (...) in its unit, b a number."""
        kept, whole = self._carry(time)
        carried = kept - np.multiply.outer(whole, self._elastic)
        a = self.relaxation.scale * np.tensordot(self._shares, carried, axes=1)
        return a, float(self.relaxation.scale * (self.relaxation.long_term_share + self._shares @ whole))

    def _carry(self, time: float) -> tuple[FloatArray, FloatArray]:
        """State of the terms at a time (k, ...), and their response to a change until then (k,)."""
        if self._time is None:
            return self._parts, np.ones(len(self._times))
        if time < self._time:
            raise PalpateError(
                f"Time goes back from {self._time:g} s to {time:g} s.",
                "Begin a new history if the clock is reset.",
                code="time-goes-back",
            )
        passed = (time - self._time) / self._times
        whole = np.where(passed > 0, -np.expm1(-passed) / np.where(passed > 0, passed, 1.0), 1.0)
        return (np.exp(-passed) * self._parts.T).T, whole

    def _sum(self, elastic: FloatArray, parts: FloatArray) -> FloatArray:
        ending: FloatArray = self.relaxation.long_term_share * elastic + np.tensordot(self._shares, parts, axes=1)
        return self.relaxation.scale * ending


def relax_history(relaxation: Relaxation, time: FloatArray, elastic: FloatArray) -> FloatArray:
    """Relax a whole history.

    Parameters
    ----------
    relaxation
        Relaxation of the material.
    time
        (n,) s, non-decreasing.
    elastic
        (n, ...) elastic value of the law, linear between the times; the first row is a step.

    Returns
    -------
    (n, ...) array
        Relaxed value, in the unit of `elastic`.
    """
    history = StressHistory(relaxation)
    return np.array([history.update(float(at), value) for at, value in zip(time, elastic, strict=True)])
