"""Interpolation of presses over tilt: at each depth, one spline per unbroken run of solved tilts.

A wall tilted by −t is the wall tilted by t seen in the mirror y → −y of the tilt frame. Interpolated quantities have
mirror images, which turn tilts 0 … 12° into a spline over −12 … 12° without an end at the untilted press.

Jumps are not interpolated: at each depth the tilts are cut into *runs*, unbroken sequences of solved tilts on one
branch (flat or inverted), and each run has its own cubic spline (not-a-knot). A tilt between two runs, or beyond the
tilts that reached the depth, has a reason instead of a value.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline, CubicSpline

from palpate.core import BoolArray, FloatArray, IntArray, PalpateError, TextArray
from palpate.fea import Press

SAME_TILT_DEG, SAME_DEPTH_MM = 1e-9, 1e-6
"""Differences up to which two tilts and two depths are equal: rounding of sums of steps."""


@dataclass(frozen=True)
class TiltRun:
    """Unbroken tilts on one branch at one depth.

    Attributes
    ----------
    first_deg, last_deg
        Minimum and maximum tilt (degrees); equal for a single press.
    branch
        ``"flat"`` or ``"inverted"``.
    spline
        Spline of the interpolated quantity by tilt (degrees).
    """

    first_deg: float
    last_deg: float
    branch: str
    spline: CubicSpline | CubicHermiteSpline

    def covers(self, tilt_deg: FloatArray) -> BoolArray:
        """Whether each tilt (n,) lies in the run."""
        return (tilt_deg >= self.first_deg - SAME_TILT_DEG) & (tilt_deg <= self.last_deg + SAME_TILT_DEG)


@dataclass(frozen=True)
class TiltRuns:
    """Runs of one skin's presses; ``runs[depth]`` are those of one depth, by ascending tilt.

    Attributes
    ----------
    tilts_deg
        (t,) solved tilts, ascending.
    branch
        (d, t) label of each solved increment; empty if the press ended before.
    ended
        (t,) reason of the end of each press.
    by_depth
        (d,) runs of each depth.
    """

    tilts_deg: FloatArray
    branch: TextArray
    ended: tuple[str, ...]
    by_depth: tuple[tuple[TiltRun, ...], ...]

    def __getitem__(self, image: int) -> tuple[TiltRun, ...]:
        return self.by_depth[image]

    def labels(self, tilt_deg: FloatArray, depth_index: int) -> tuple[TextArray, TextArray]:
        """Return the branch of each tilt at one depth, or the reason why it is missing.

        Parameters
        ----------
        tilt_deg
            (n,) tilts, not negative.
        depth_index
            Number of the depth.

        Returns
        -------
        tuple[TextArray, TextArray]
            (n,) branch and (n,) reason, of which one is empty.
        """
        branch = np.full(len(tilt_deg), "", dtype="U16")
        for run in self[depth_index]:
            branch[run.covers(tilt_deg)] = run.branch
        missing = branch == ""
        reason = np.full(len(tilt_deg), "", dtype="U80")
        reason[missing] = [self._reason(tilt, depth_index) for tilt in tilt_deg[missing]]
        return branch, reason

    def read(self, tilt_deg: FloatArray, depth_index: int) -> Iterator[tuple[BoolArray, NDArray[Any]]]:
        """Yield for every run at a depth: which of the tilts (n,) it covers, and the values there."""
        for run in self[depth_index]:
            chosen = run.covers(tilt_deg)
            if chosen.any():
                yield chosen, run.spline(np.clip(tilt_deg[chosen], run.first_deg, run.last_deg))

    def neighbours(self, tilt_deg: float) -> tuple[int, ...]:
        """Indices of the solved tilts next to a tilt, the larger first; only one if the tilt was solved."""
        above = int(np.searchsorted(self.tilts_deg, tilt_deg - SAME_TILT_DEG))
        solved = above < len(self.tilts_deg) and abs(self.tilts_deg[above] - tilt_deg) <= SAME_TILT_DEG
        return (above,) if solved else (above, above - 1)

    def _reason(self, tilt_deg: float, image: int) -> str:
        neighbours = self.neighbours(tilt_deg)
        if neighbours[0] == len(self.tilts_deg):
            return "beyond the solved tilts"
        if min(neighbours) < 0:
            return "below the solved tilts"
        for neighbour in neighbours:
            if self.branch[image, neighbour] == "":
                return self.ended[neighbour]
        return "between the flat and the inverted branch"


def cut_into_runs(
    tilts_deg: FloatArray,
    branch: TextArray,
    ended: Sequence[str],
    values: NDArray[Any],
    mirrored: NDArray[Any] | None,
    slopes: NDArray[Any] | None = None,
) -> TiltRuns:
    """Cut presses into runs, with a spline through their values at each depth.

    With slopes, the spline is Hermite's; a run with a non-finite slope has the spline through the values.

    Parameters
    ----------
    tilts_deg, branch, ended
        See `TiltRuns`.
    values, mirrored
        (d, t, …) values of the presses and their mirror images, real or complex; without the latter a run ends at the
        untilted press.
    slopes
        (d, t, …) derivative of the values by the tilt, over a degree.
    """
    others = ([None] * len(branch) if part is None else part for part in (mirrored, slopes))
    rows = zip(branch, values, *others, strict=True)
    return TiltRuns(
        tilts_deg,
        branch,
        tuple(ended),
        tuple(_cut(tilts_deg, *row) for row in rows),
    )


def label_presses(presses: Sequence[Press], depths_mm: FloatArray) -> TextArray:
    """Labels (d, t) of presses by ascending tilt at common depths (d,); empty if a press ended before."""
    branch = np.full((len(depths_mm), len(presses)), "", dtype="U16")
    for column, press in enumerate(presses):
        depth, image = match_depths(depths_mm, press)
        branch[depth, column] = press.branch[image]
    return branch


def match_depths(depths_mm: FloatArray, press: Press) -> tuple[IntArray, IntArray]:
    """Indices of the depths (d,) in mm that a press has, and of its loading increments at these depths."""
    down = int(np.argmax(press.depth)) + 1
    depth, image = np.nonzero(np.abs(depths_mm[:, None] - press.depth[None, :down]) <= SAME_DEPTH_MM)
    return depth, image


def interpolate_depths(press: Press, values: FloatArray, depths_mm: FloatArray) -> FloatArray:
    """Values (d, …) of a press at any depths (d,) mm, from those (i, …) of its increments.

    By the cubic spline through the increments on the way down; before first contact as at rest, NaN beyond the last.
    """
    down = int(np.argmax(press.depth)) + 1
    found = np.full((len(depths_mm), *values.shape[1:]), np.nan)
    reached = depths_mm <= press.depth[down - 1] + SAME_DEPTH_MM
    found[reached] = CubicSpline(press.depth[:down], values[:down])(np.maximum(depths_mm[reached], 0.0))
    return found


def shared_depths(presses: Sequence[Press]) -> FloatArray:
    """Return the common depths (mm) of increments after rest, without a last state between two of them.

    Raises
    ------
    PalpateError
        If there is no press, a tilt appears twice, or the depth steps differ.
    """
    if not presses:
        raise PalpateError(
            "An interpolation needs at least one press.", "Solve the straight press first.", code="presses-none"
        )
    steps = {round(float(press.obstacle.depth_step), 9) for press in presses}
    if len(steps) > 1:
        raise PalpateError(
            f"The presses have images every {sorted(steps)} mm.",
            "Give all of them one image step.",
            code="presses-steps-differ",
        )
    tilts = sorted(press.obstacle.radial for press in presses)
    repeated = next((tilt for tilt, after in pairwise(tilts) if tilt == after), None)
    if repeated is not None:
        raise PalpateError(f"The tilt {repeated:g}° was given twice.", "Keep one press a tilt.", code="tilt-twice")
    step = steps.pop()
    reached = max(float(press.depth.max()) for press in presses)
    depths: FloatArray = step * np.arange(1.0, int((reached + SAME_DEPTH_MM) / step) + 1)
    return depths


def _cut(
    tilts: FloatArray,
    branch: TextArray,
    values: NDArray[Any],
    mirrored: NDArray[Any] | None,
    slopes: NDArray[Any] | None,
) -> tuple[TiltRun, ...]:
    """Runs of one depth from the labels (t,), values (t, …) and slopes of every solved tilt."""
    starts = [0, *(np.flatnonzero(branch[1:] != branch[:-1]) + 1), len(tilts)]
    return tuple(
        TiltRun(
            float(tilts[a]),
            float(tilts[b - 1]),
            str(branch[a]),
            _spline(tilts[a:b], values[a:b], *(None if part is None else part[a:b] for part in (mirrored, slopes))),
        )
        for a, b in pairwise(starts)
        if branch[a] != ""
    )


def _spline(
    tilts: FloatArray, values: NDArray[Any], mirrored: NDArray[Any] | None, slopes: NDArray[Any] | None
) -> CubicSpline | CubicHermiteSpline:
    """Cubic spline of a run; one that starts at the untilted press is continued by its mirror image."""
    if len(tilts) == 1:  # a constant: the run covers this tilt alone
        return CubicSpline([tilts[0], tilts[0] + 1.0], np.concatenate([values, values]))
    if slopes is not None and np.isfinite(slopes).all():
        return CubicHermiteSpline(tilts, values, slopes)
    if tilts[0] == 0.0 and mirrored is not None:
        tilts = np.concatenate([-tilts[:0:-1], tilts])
        values = np.concatenate([mirrored[:0:-1], values])
    return CubicSpline(tilts, values)
