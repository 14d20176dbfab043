"""Displacement along circles of a pressed skin, as Fourier series about the wall's azimuth.

The undeformed skin is a body of revolution, so a rotation of the wall to another azimuth rotates the whole solution;
the same holds for the position of a ball. In cylindrical components (radial, azimuthal, axial) the displacement of a
point at azimuth φ depends on the turn α of the half model that was solved (for a wall, its azimuth) only through
their difference

    u(φ; α) = Re Σ_k c_k exp(i k ψ),      ψ = φ − α − 90°

and ψ = 0 is the direction of the wall's rotation vector turned by 90° (+y for azimuth 0), where the mirror
plane of the problem cuts the circle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from palpate.core import FloatArray
from palpate.fea import Press

ComplexArray = NDArray[np.complex128]
"""Coefficients of Fourier series."""
SAMPLES = 96
"""Points on a circle. By hand."""
ORDERS = 40
"""Orders 0 … 39 of the series are kept: wave lengths down to 9° of azimuth. By hand."""
QUARTER_TURN = np.pi / 2
"""Difference between the azimuths of mesh and press."""


@dataclass(frozen=True)
class MarkerCircles:
    """Markers sorted onto circles about the skin's axis.

    Attributes
    ----------
    radius, height
        (c,) mm, radius of each circle about the axis and its z.
    circle
        (m,) number of the circle on which each marker lies.
    azimuth
        (m,) rad, azimuth of each marker; 0 for one on the axis.
    """

    radius: FloatArray
    height: FloatArray
    circle: NDArray[np.intp]
    azimuth: FloatArray


def sort_onto_circles(positions: FloatArray) -> MarkerCircles:
    """Find the distinct circles on which undeformed markers (m, 3) in mm lie, to within 10⁻⁶ mm."""
    radius = np.hypot(positions[:, 0], positions[:, 1])
    rounded = np.round(np.stack([radius, positions[:, 2]], axis=1), 6)
    _, first, circle = np.unique(rounded, axis=0, return_index=True, return_inverse=True)
    azimuth = np.where(radius > 0, np.arctan2(positions[:, 1], positions[:, 0]), 0.0)
    return MarkerCircles(radius[first], positions[first, 2], circle.reshape(-1), azimuth)


def expand_press(press: Press, circles: MarkerCircles, by: str = "") -> ComplexArray:
    """Fourier series of one press on every circle, or of its derivative.

    Parameters
    ----------
    press
        A solved press at any azimuth of the wall.
    circles
        Where the markers lie.
    by
        Name of the derivative; empty: the press itself.

    Returns
    -------
    ComplexArray
        Coefficients c_k in mm, (n images, c circles, 3 components, `ORDERS`).
    """
    psi = 2 * np.pi * np.arange(SAMPLES) / SAMPLES
    phi = psi + np.deg2rad(press.obstacle.turn_deg) + QUARTER_TURN
    cosine, sine = np.cos(phi), np.sin(phi)
    points = np.empty((len(circles.radius), SAMPLES, 3))
    points[..., 0] = circles.radius[:, None] * cosine
    points[..., 1] = circles.radius[:, None] * sine
    points[..., 2] = circles.height[:, None]
    moved = press.displacement_at(points.reshape(-1, 3), by).reshape(-1, *points.shape)
    cylindrical = np.stack(
        [
            moved[..., 0] * cosine + moved[..., 1] * sine,
            -moved[..., 0] * sine + moved[..., 1] * cosine,
            moved[..., 2],
        ],
        axis=-2,
    )
    series = 2.0 * np.fft.rfft(cylindrical, axis=-1)[..., :ORDERS] / SAMPLES
    series[..., 0] /= 2.0
    return np.asarray(series)


def sum_series(series: ComplexArray, turn: FloatArray, circles: MarkerCircles) -> FloatArray:
    """Displacement (n, m, 3) mm of markers, of coefficients (n, c, 3, k) at turns (n,) in rad of the mesh."""
    order = np.arange(ORDERS)
    turned = series * np.exp(-1j * order * (turn[:, None] + QUARTER_TURN))[:, None, None, :]
    moved = np.empty((len(turn), 3, len(circles.circle)))
    for number in range(len(circles.radius)):
        members = np.flatnonzero(circles.circle == number)
        wave = np.exp(1j * order[:, None] * circles.azimuth[members])
        moved[:, :, members] = (turned[:, number].real @ wave.real) - (turned[:, number].imag @ wave.imag)
    cosine, sine = np.cos(circles.azimuth), np.sin(circles.azimuth)
    radial, azimuthal, axial = moved[:, 0], moved[:, 1], moved[:, 2]
    return np.stack([radial * cosine - azimuthal * sine, radial * sine + azimuthal * cosine, axial], axis=-1)
