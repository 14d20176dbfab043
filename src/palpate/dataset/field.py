"""Where the markers are for any pose of the wall, interpolated from a handful of solved presses.

One press serves every azimuth (see `circle`); between tilts every Fourier coefficient is a cubic spline. A
wall tilted by −t is the wall tilted by t and turned by half a turn, hence the parity

    c_k(−t) = (−1)^k c_k(t)

which turns tilts 0 … 12° into a spline over −12 … 12° without an end at the straight press.

Nothing is interpolated across a jump: at each depth the tilts are cut into *runs*, unbroken sequences of
solved tilts on one branch (flat or inverted), and each run has its own spline. A pose between two runs, or
beyond the tilts that reached the depth, has no answer, only a reason.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from scipy.interpolate import CubicSpline

from palpate.core import BoolArray, ComplexArray, FloatArray, PalpateError, TextArray
from palpate.dataset.circle import ORDERS, QUARTER_TURN, MarkerCircles, expand_press, sort_onto_circles

if TYPE_CHECKING:
    from palpate.design import MarkerLayout
    from palpate.fea import Press


SAME_TILT_DEG = 1e-9
SAME_DEPTH_MM = 1e-6


@dataclass(frozen=True)
class TiltRun:
    """Unbroken tilts on one branch at one depth.

    Attributes
    ----------
    first_deg, last_deg
        Least and greatest tilt (degrees); equal where a single press stands alone.
    branch
        ``"flat"`` or ``"inverted"``.
    spline
        Tilt (degrees) → Fourier coefficients (c, 3, `ORDERS`) in mm.
    """

    first_deg: float
    last_deg: float
    branch: str
    spline: CubicSpline

    def covers(self, tilt_deg: FloatArray) -> BoolArray:
        """Whether each tilt (n,) lies in the run."""
        return (tilt_deg >= self.first_deg - SAME_TILT_DEG) & (tilt_deg <= self.last_deg + SAME_TILT_DEG)


@dataclass(frozen=True)
class MarkerField:
    """Positions of a layout's markers over the disc of tilts, one image a depth.

    Attributes
    ----------
    rest
        (m, 3) mm, undeformed markers.
    circles
        The same markers on their circles.
    depths_mm
        (d,) depths of the images after rest.
    tilts_deg
        (t,) solved tilts, rising.
    branch
        (d, t) label of each solved image; empty where the press ended before.
    ended
        (t,) reason of the end of each press.
    runs
        For each depth, its runs by rising tilt.
    series_error_mm
        Largest distance between a point sampled from a press and the Fourier series there.
    """

    rest: FloatArray
    circles: MarkerCircles
    depths_mm: FloatArray
    tilts_deg: FloatArray
    branch: TextArray
    ended: tuple[str, ...]
    runs: tuple[tuple[TiltRun, ...], ...]
    series_error_mm: float

    def labels(self, tilt_deg: FloatArray, image: int) -> tuple[TextArray, TextArray]:
        """Branch of each tilt (n,) at one depth, or why there is none.

        Parameters
        ----------
        tilt_deg
            (n,) tilts, not negative.
        image
            Number of the depth in `depths_mm`.

        Returns
        -------
        tuple[TextArray, TextArray]
            (n,) branch, empty where there is none, and (n,) reason, empty where there is a branch.
        """
        branch = np.full(len(tilt_deg), "", dtype="U16")
        for run in self.runs[image]:
            branch[run.covers(tilt_deg)] = run.branch
        missing = branch == ""
        reason = np.full(len(tilt_deg), "", dtype="U80")
        reason[missing] = [self._reason(tilt, image) for tilt in tilt_deg[missing]]
        return branch, reason

    def positions(self, rx_deg: FloatArray, ry_deg: FloatArray, image: int) -> FloatArray:
        """Deformed positions of the markers.

        Parameters
        ----------
        rx_deg, ry_deg
            (n,) components of the wall's rotation.
        image
            Number of the depth in `depths_mm`.

        Returns
        -------
        FloatArray
            (n, m, 3) mm; NaN for a pose that no run covers (`labels` says why).
        """
        tilt = np.hypot(rx_deg, ry_deg)
        azimuth = np.arctan2(ry_deg, rx_deg)
        moved = np.full((len(tilt), 3, len(self.rest)), np.nan)
        for run in self.runs[image]:
            chosen = run.covers(tilt)
            if chosen.any():
                series = run.spline(np.clip(tilt[chosen], run.first_deg, run.last_deg))
                moved[chosen] = _sum_series(series, azimuth[chosen], self.circles)
        cosine, sine = np.cos(self.circles.azimuth), np.sin(self.circles.azimuth)
        radial, azimuthal, axial = moved[:, 0], moved[:, 1], moved[:, 2]
        displacement = (radial * cosine - azimuthal * sine, radial * sine + azimuthal * cosine, axial)
        moved_points: FloatArray = self.rest + np.stack(displacement, axis=-1)
        return moved_points

    def _reason(self, tilt_deg: float, image: int) -> str:
        above = int(np.searchsorted(self.tilts_deg, tilt_deg - SAME_TILT_DEG))
        if above == len(self.tilts_deg):
            return "beyond the solved tilts"
        neighbours = [above] if abs(self.tilts_deg[above] - tilt_deg) <= SAME_TILT_DEG else [above, above - 1]
        if min(neighbours) < 0:
            return "below the solved tilts"
        for neighbour in neighbours:
            if self.branch[image, neighbour] == "":
                return self.ended[neighbour]
        return "between the flat and the inverted branch"


def build_field(presses: Sequence[Press], markers: MarkerLayout) -> MarkerField:
    """Interpolate presses of one dome, which differ by the tilt of the wall alone.

    Parameters
    ----------
    presses
        At least one; the images must be the same distance apart.
    markers
        Layout of undeformed markers on the inner surface.

    Returns
    -------
    MarkerField
        Positions of the markers for every pose that the presses support.

    Raises
    ------
    PalpateError
        If there is no press, a tilt appears twice, the image steps differ, or a marker is not on the dome.
    """
    outside = int((~np.isfinite(markers.positions).all(axis=1)).sum())
    if outside:
        raise PalpateError(f"{outside} markers lie outside the dome.", "Leave them out, or use smaller rings.")
    presses = sorted(presses, key=lambda press: press.wall.radial)
    depths = _image_depths(presses)
    tilts = np.array([press.wall.radial for press in presses], dtype=float)
    circles = sort_onto_circles(markers.positions)
    series = np.full((len(depths), len(tilts), len(circles.radius), 3, ORDERS), np.nan, dtype=complex)
    branch = np.full((len(depths), len(tilts)), "", dtype="U16")
    errors = []
    for column, press in enumerate(presses):
        coefficients, error = expand_press(press, circles)
        errors.append(error)
        image, depth = np.nonzero(np.abs(press.depth[:, None] - depths) <= SAME_DEPTH_MM)
        series[depth, column] = coefficients[image]
        branch[depth, column] = press.branch[image]
    return MarkerField(
        rest=np.asarray(markers.positions, dtype=float),
        circles=circles,
        depths_mm=depths,
        tilts_deg=tilts,
        branch=branch,
        ended=tuple(str(press.ended) for press in presses),
        runs=tuple(_cut_into_runs(tilts, *row) for row in zip(branch, series, strict=True)),
        series_error_mm=max(errors),
    )


def _image_depths(presses: Sequence[Press]) -> FloatArray:
    """Depths (mm) of the images after rest; a last state between two images is left out."""
    if not presses:
        raise PalpateError("A marker field needs at least one press.", "Solve the straight press first.")
    steps = {round(float(press.wall.image_step), 9) for press in presses}
    if len(steps) > 1:
        raise PalpateError(f"The presses have images every {sorted(steps)} mm.", "Give all of them one image step.")
    tilts = [press.wall.radial for press in presses]
    repeated = next((tilt for tilt, after in pairwise(tilts) if tilt == after), None)
    if repeated is not None:
        raise PalpateError(f"The tilt {repeated:g}° was given twice.", "Keep one press a tilt.")
    step = steps.pop()
    reached = max(float(press.depth[-1]) for press in presses)
    depths: FloatArray = step * np.arange(1.0, int((reached + SAME_DEPTH_MM) / step) + 1)
    return depths


def _cut_into_runs(tilts: FloatArray, branch: TextArray, series: ComplexArray) -> tuple[TiltRun, ...]:
    """Runs of one depth from the labels (t,) and coefficients (t, c, 3, k) of every solved tilt."""
    starts = [0, *(np.flatnonzero(branch[1:] != branch[:-1]) + 1), len(tilts)]
    return tuple(
        TiltRun(float(tilts[a]), float(tilts[b - 1]), str(branch[a]), _spline(tilts[a:b], series[a:b]))
        for a, b in pairwise(starts)
        if branch[a] != ""
    )


def _spline(tilts: FloatArray, series: ComplexArray) -> CubicSpline:
    """Cubic spline (not-a-knot) of a run; one that starts at the straight press is continued by parity."""
    if tilts[0] == 0.0 and len(tilts) > 1:
        parity = (-1.0) ** np.arange(ORDERS)
        tilts = np.concatenate([-tilts[:0:-1], tilts])
        series = np.concatenate([parity * series[:0:-1], series])
    if len(tilts) == 1:  # a constant: the run covers this tilt alone
        tilts, series = np.array([tilts[0], tilts[0] + 1.0]), np.concatenate([series, series])
    return CubicSpline(tilts, series)


def _sum_series(series: ComplexArray, azimuth: FloatArray, circles: MarkerCircles) -> FloatArray:
    """Cylindrical displacement (n, 3, m) from coefficients (n, c, 3, k) and azimuths (n,) of the wall."""
    order = np.arange(ORDERS)
    turned = series * np.exp(-1j * order * (azimuth[:, None] + QUARTER_TURN))[:, None, None, :]
    moved = np.empty((len(azimuth), 3, len(circles.circle)))
    for number in range(len(circles.radius)):
        members = np.flatnonzero(circles.circle == number)
        wave = np.exp(1j * order[:, None] * circles.azimuth[members])
        moved[:, :, members] = (turned[:, number].real @ wave.real) - (turned[:, number].imag @ wave.imag)
    return moved
