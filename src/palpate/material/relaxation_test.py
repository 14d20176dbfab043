"""Relaxation test: stress through time under a strain that is applied and held."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray, PalpateError

LEAST_ROWS = 8
"""Minimum number of rows of a relaxation curve. By hand."""
_DECADE = 10.0
"""Minimum ratio of the last time to the first. By hand."""
_RISES = 0.02
"""Share of the maximum stress by which a held stress may increase, by noise of the machine. By hand."""
_RAMP = 0.5
"""Share of the maximum stress below which the first value shows that the strain was still increasing.
By hand."""
_WHOLE, _NOTHING = 0.99, 0.01
"""Shares of the held strain, or of the maximum stress, at which the ramp ends and begins. By hand."""
_BINS = 8
"""Intervals of log time whose means are tested for an increase. By hand."""


@dataclass(frozen=True, eq=False)
class RelaxationTest:
    """One specimen that was strained and held.

    Attributes
    ----------
    name
        File.
    time
        (n,) s, ascending; without `strain`, since the strain was applied.
    stress
        (n,) positive, in any unit of stress or force: its size does not matter.
    strain
        (n,) in any unit, positive, if measured; `None`: a step at time 0, or, if the stress increases first, a linear
        ramp up to its peak.
    notes
        Assumptions, for the report.
    """

    name: str
    time: FloatArray
    stress: FloatArray
    strain: FloatArray | None = None
    notes: tuple[str, ...] = ()

    @property
    def ramp_times(self) -> tuple[float, float]:
        """Times in s of the begin and end of the ramp; without `strain`, both 0 for a step."""
        if self.strain is not None:
            rises, held = self.strain, self._strain_held
            whole = int(np.argmax(rises >= _WHOLE * held))
        else:
            rises, whole = self.stress, int(np.argmax(self.stress))
            held = float(rises[whole])
            if rises[0] >= _RAMP * held:
                return 0.0, 0.0
        begun = np.flatnonzero(rises[:whole] <= _NOTHING * held)
        return float(self.time[begun[-1] if len(begun) else 0]), float(self.time[whole])

    @property
    def strain_history(self) -> tuple[FloatArray, FloatArray]:
        """Strain history: times (n,) s since it began, the first 0, and the strain over the held one.

        A value at time 0 is a step.
        """
        begun, whole = self.ramp_times
        after = self.time >= begun
        since = self.time[after] - begun
        if self.strain is not None:
            strain = self.strain[after] / self._strain_held
        elif whole > begun:
            strain = np.minimum(since / (whole - begun), 1.0)
        else:
            strain = np.ones(len(since))
        return np.append(0.0, since), np.append(strain[0], strain)

    @property
    def _strain_held(self) -> float:
        """Median of the second half of the strain."""
        assert self.strain is not None
        return float(np.median(self.strain[len(self.strain) // 2 :]))

    @property
    def first(self) -> float:
        """Shortest time in s after the strain began that the test resolves."""
        begun, whole = self.ramp_times
        return whole - begun if whole > begun else float(self.time[self.time > begun][0] - begun)

    @property
    def last(self) -> float:
        """Longest time in s after the strain began."""
        return float(self.time[-1] - self.ramp_times[0])

    def check(self) -> None:
        """Reject a test that shows no relaxation, with a `PalpateError`."""
        if len(self.time) < LEAST_ROWS:
            raise PalpateError(
                f"{self.name} has {len(self.time)} row{'s' if len(self.time) != 1 else ''} of numbers.",
                f"A relaxation needs {LEAST_ROWS} or more: export the whole test.",
                code="table-few-rows",
            )
        back = np.flatnonzero(np.diff(self.time) <= 0)
        if len(back):
            raise PalpateError(
                f"{self.name}: after {self.time[back[0]]:g} s comes {self.time[back[0] + 1]:g} s.",
                "Times must rise: give one test a file, in the order in which it was measured.",
                code="times-not-rising",
            )
        if self.strain is not None and self._strain_held <= 0:
            raise PalpateError(
                f"{self.name}: in the second half of its rows the strain is gone.",
                "Cut the rows after the strain is released, and check the column of strain.",
                code="strain-released",
            )
        begun, whole = self.ramp_times
        if begun == whole == 0.0 and self.time[0] < 0:
            raise PalpateError(
                f"{self.name} begins at {self.time[0]:g} s and has no strain.",
                "Count time from when the strain came.",
                code="strain-missing",
            )
        if self.last < _DECADE * self.first:
            raise PalpateError(
                f"{self.name} goes from {self.first:.3g} s to {self.last:.3g} s after the strain began.",
                "A relaxation needs a decade of time or more: strain faster or hold longer.",
                code="relaxation-too-short",
            )
        self._check_held(begun, whole)

    def _check_held(self, begun: float, whole: float) -> None:
        """Reject a held stress that increases or changes its sign."""
        held = self.time >= whole
        time, stress = self.time[held] - begun, self.stress[held]
        least = float(time[time > 0][0])
        edges = np.geomspace(least, time[-1], _BINS + 1)
        bin_of = np.clip(np.searchsorted(edges, np.maximum(time, least), side="right") - 1, 0, _BINS - 1)
        kept = [at for at in range(_BINS) if np.any(bin_of == at)]
        mean = np.array([stress[bin_of == at].mean() for at in kept])
        when = begun + np.array([time[bin_of == at].mean() for at in kept])
        low = int(np.argmin(mean))
        if mean[low:].max() - mean[low] > _RISES * stress.max():
            high = low + int(np.argmax(mean[low:]))
            raise PalpateError(
                f"{self.name}: the held stress rises from {mean[low]:.4g} at {when[low]:.3g} s to {mean[high]:.4g} "
                f"at {when[high]:.3g} s.",
                "Give a test whose strain stays, without drift of the cell, and cut the rows after it.",
                code="held-stress-rises",
            )
        if mean.min() <= 0:
            raise PalpateError(
                f"{self.name}: the stress falls to {mean.min():.4g} and changes its sign.",
                "Set the cell to zero before the strain comes, or cut the unloading.",
                code="held-stress-changes-sign",
            )
