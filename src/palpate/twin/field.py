"""Where the markers are for any pose of the obstacle, interpolated from a handful of solved presses.

One press serves every azimuth (see `circle`); between tilts every Fourier coefficient is a cubic spline (see
`tilt_runs`). A wall tilted by −t is the wall tilted by t and turned by half a turn, hence the parity

    c_k(−t) = (−1)^k c_k(t)

and so it is for a ball offset by −t. In what follows the *tilt* of an obstacle that does not tilt is its offset in
mm.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray, PalpateError, TextArray
from palpate.design import TILT_DEPTH, MarkerLayout, PoseSpace, Symmetry
from palpate.fea import Press
from palpate.twin.circle import ORDERS, QUARTER_TURN, ComplexArray, MarkerCircles, expand_press, sort_onto_circles
from palpate.twin.tilt_runs import TiltRuns, cut_into_runs, label_presses, match_depths, shared_depths

SLOPE = "tilt_deg"
"""Derivative with which presses are interpolated by value and slope, where all of them have it."""


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
        (d,) depths of the images.
    runs
        Runs of tilts at each depth, whose splines give Fourier coefficients (c, 3, `ORDERS`) in mm.
    series_error_mm
        Largest distance between a point sampled from a press and the Fourier series there.
    space
        What the presses' poses are.
    """

    rest: FloatArray
    circles: MarkerCircles
    depths_mm: FloatArray
    runs: TiltRuns
    series_error_mm: float
    space: PoseSpace = TILT_DEPTH

    @property
    def offset(self) -> float | None:
        """Greatest offset that was pressed, mm; `None` for walls, whose greatest tilt a dataset's spec says."""
        return None if self.space.tilts else float(self.runs.tilts_deg[-1])

    def labels(self, tilt_deg: FloatArray, image: int) -> tuple[TextArray, TextArray]:
        """Branch of each tilt (n,) at one depth, or why there is none; see `TiltRuns.labels`."""
        return self.runs.labels(tilt_deg, image)

    def positions(self, rx_deg: FloatArray, ry_deg: FloatArray, image: int) -> FloatArray:
        """Deformed positions of the markers.

        Parameters
        ----------
        rx_deg, ry_deg
            (n,) components of the wall's rotation; of another obstacle, its x and y in mm.
        image
            Number of the depth in `depths_mm`.

        Returns
        -------
        FloatArray
            (n, m, 3) mm; NaN for a pose that no run covers (`labels` says why).
        """
        tilt = np.hypot(rx_deg, ry_deg)
        turn = np.arctan2(ry_deg, rx_deg) + np.radians(self.space.turn_deg)
        moved = np.full((len(tilt), 3, len(self.rest)), np.nan)
        for chosen, series in self.runs.read(tilt, image):
            moved[chosen] = _sum_series(series, turn[chosen], self.circles)
        cosine, sine = np.cos(self.circles.azimuth), np.sin(self.circles.azimuth)
        radial, azimuthal, axial = moved[:, 0], moved[:, 1], moved[:, 2]
        displacement = (radial * cosine - azimuthal * sine, radial * sine + azimuthal * cosine, axial)
        moved_points: FloatArray = self.rest + np.stack(displacement, axis=-1)
        return moved_points


def build_field(presses: Sequence[Press], markers: MarkerLayout, depths_mm: FloatArray | None = None) -> MarkerField:
    """Interpolate presses of one skin, which differ by the tilt of the wall, or the offset of the obstacle, alone.

    Parameters
    ----------
    presses
        At least one; the images must be the same distance apart.
    markers
        Layout of undeformed markers on the inner surface.
    depths_mm
        (d,) rising; without them, those of the images after rest.

    Returns
    -------
    MarkerField
        Positions of the markers for every pose that the presses support.

    Raises
    ------
    PalpateError
        If there is no press, a tilt appears twice, the image steps differ, or a marker is not on the dome.
    """
    _refuse_without_symmetry(presses)
    spaces = {press.wall.pose_space for press in presses}
    if len(spaces) > 1:
        raise PalpateError("The presses are of obstacles with different poses.", "Give presses of one obstacle.")
    outside = int((~np.isfinite(markers.positions).all(axis=1)).sum())
    if outside:
        raise PalpateError(f"{outside} markers lie outside the dome.", "Leave them out, or use smaller rings.")
    presses = sorted(presses, key=lambda press: press.wall.radial)
    depths = shared_depths(presses) if depths_mm is None else depths_mm
    tilts = np.array([press.wall.radial for press in presses], dtype=float)
    circles = sort_onto_circles(markers.positions)
    series = np.full((len(depths), len(tilts), len(circles.radius), 3, ORDERS), np.nan, dtype=complex)
    sloped = all(SLOPE in press.derivatives for press in presses)
    slopes, errors = np.full_like(series, np.nan), []
    for column, press in enumerate(presses):
        coefficients, error = expand_press(press, circles)
        errors.append(error)
        depth, image = match_depths(depths, press)
        series[depth, column] = coefficients[image]
        if sloped:
            slopes[depth, column] = expand_press(press, circles, by=SLOPE)[0][image]
    branch, ended = label_presses(presses, depths), [str(press.ended) for press in presses]
    parity = (-1.0) ** np.arange(ORDERS)
    return MarkerField(
        rest=np.asarray(markers.positions, dtype=float),
        circles=circles,
        depths_mm=depths,
        runs=cut_into_runs(tilts, branch, ended, series, parity * series, slopes if sloped else None),
        series_error_mm=max(errors),
        space=spaces.pop(),
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


def _refuse_without_symmetry(presses: Sequence[Press]) -> None:
    """One press serves every azimuth of a body of revolution alone."""
    for press in presses:
        skin = press.mesh.skin
        if skin.symmetry is not Symmetry.REVOLVED:
            raise PalpateError(
                f"{skin.name} is no body of revolution: one press does not serve every azimuth.",
                "Press every azimuth and read single presses; images of such a skin are not interpolated.",
            )
