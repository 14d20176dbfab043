"""Where the markers of a body of revolution are for any pose, interpolated from a handful of solved presses.

One press serves every azimuth (see `circle`); between tilts every Fourier coefficient is a cubic spline (see
`tilt_runs`). A wall tilted by −t is the wall tilted by t and turned by half a turn, hence the parity

    c_k(−t) = (−1)^k c_k(t)

and so it is for a ball offset by −t. In what follows the *tilt* of an obstacle that does not tilt is its offset in
mm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from palpate.core import FloatArray
from palpate.design import MarkerLayout
from palpate.fea import Press
from palpate.twin.circle import ORDERS, QUARTER_TURN, ComplexArray, MarkerCircles, expand_press, sort_onto_circles
from palpate.twin.marker_field import MarkerField
from palpate.twin.tilt_runs import cut_into_runs, label_presses, match_depths

SLOPE = "tilt_deg"
"""Derivative with which presses are interpolated by value and slope, where all of them have it."""


@final
@dataclass(frozen=True)
class RevolvedField(MarkerField):
    """Markers of a body of revolution.

    Attributes
    ----------
    circles
        The same markers on their circles.
    runs
        See `MarkerField`; their splines give Fourier coefficients (c, 3, `ORDERS`) in mm.
    series_error_mm
        Largest distance between a point sampled from a press and the Fourier series there.
    """

    circles: MarkerCircles
    series_error_mm: float

    def positions(self, rx_deg: FloatArray, ry_deg: FloatArray, depth_index: int) -> FloatArray:
        tilt = np.hypot(rx_deg, ry_deg)
        turn = np.arctan2(ry_deg, rx_deg) + np.radians(self.space.turn_deg)
        moved = np.full((len(tilt), 3, len(self.rest)), np.nan)
        for chosen, series in self.runs.read(tilt, depth_index):
            moved[chosen] = _sum_series(series, turn[chosen], self.circles)
        cosine, sine = np.cos(self.circles.azimuth), np.sin(self.circles.azimuth)
        radial, azimuthal, axial = moved[:, 0], moved[:, 1], moved[:, 2]
        displacement = (radial * cosine - azimuthal * sine, radial * sine + azimuthal * cosine, axial)
        moved_points: FloatArray = self.rest + np.stack(displacement, axis=-1)
        return moved_points


def build_revolved_field(presses: Sequence[Press], markers: MarkerLayout, depths_mm: FloatArray) -> RevolvedField:
    """Interpolate presses of one body of revolution: see `palpate.twin.build_field`, which has looked at them."""
    presses = sorted(presses, key=lambda press: press.obstacle.radial)
    tilts = np.array([press.obstacle.radial for press in presses], dtype=float)
    circles = sort_onto_circles(markers.positions)
    series = np.full((len(depths_mm), len(tilts), len(circles.radius), 3, ORDERS), np.nan, dtype=complex)
    sloped = all(SLOPE in press.derivatives for press in presses)
    slopes, errors = np.full_like(series, np.nan), []
    for column, press in enumerate(presses):
        coefficients, error = expand_press(press, circles)
        errors.append(error)
        depth, image = match_depths(depths_mm, press)
        series[depth, column] = coefficients[image]
        if sloped:
            slopes[depth, column] = expand_press(press, circles, by=SLOPE)[0][image]
    branch, ended = label_presses(presses, depths_mm), [str(press.ended) for press in presses]
    parity = (-1.0) ** np.arange(ORDERS)
    return RevolvedField(
        rest=np.asarray(markers.positions, dtype=float),
        depths_mm=depths_mm,
        runs=cut_into_runs(tilts, branch, ended, series, parity * series, slopes if sloped else None),
        space=presses[0].obstacle.pose_space,
        circles=circles,
        series_error_mm=max(errors),
    )


def _sum_series(series: ComplexArray, turn: FloatArray, circles: MarkerCircles) -> FloatArray:
    """Cylindrical displacement (n, 3, m) from coefficients (n, c, 3, k) and turns (n,) in rad of the mesh."""
    order = np.arange(ORDERS)
    turned = series * np.exp(-1j * order * (turn[:, None] + QUARTER_TURN))[:, None, None, :]
    moved = np.empty((len(turn), 3, len(circles.circle)))
    for number in range(len(circles.radius)):
        members = np.flatnonzero(circles.circle == number)
        wave = np.exp(1j * order[:, None] * circles.azimuth[members])
        moved[:, :, members] = (turned[:, number].real @ wave.real) - (turned[:, number].imag @ wave.imag)
    return moved
