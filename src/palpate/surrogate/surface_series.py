"""Displacement of a pressed inner surface, as Fourier series on circles from the apex to the rim.

In cylindrical components, and with the azimuth ψ counted from the intersection of the surface with the mirror plane
of the tilt (see `circle`), the displacement under a wall is even in ψ radially and axially, and odd azimuthally:

    u_r = Σ_k r_k(s) cos kψ,    u_φ = Σ_k f_k(s) sin kψ,    u_z = Σ_k z_k(s) cos kψ,

with the place s on the meridian of the unit disc, 0 at the apex and 1 at the rim. All coefficients are real and
determined by half a circle. Parts that break the mirror symmetry, as under a wall that moves across its slope, have
the opposite parity: ``u_r = Σ r_k sin kψ, u_φ = -Σ f_k cos kψ, u_z = Σ z_k sin kψ``, the same waves shifted by a
quarter.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from palpate.core import FloatArray
from palpate.design import Skin
from palpate.fea import Press
from palpate.mesh import locate_inner, marker_displacement, marker_displacement_derivative
from palpate.surrogate.circle import QUARTER_TURN

ORDERS = 14
"""Orders 0 … 13 of the series are kept: wave lengths down to 28° of azimuth. By hand."""
CIRCLES = 33
"""Circles from the apex to the rim. By hand."""
_HALF = 32
"""Equal parts of half a circle. By hand."""


def place_circles() -> FloatArray:
    """Places (`CIRCLES`,) of the circles on the meridian, denser towards the apex and the rim."""
    angle: FloatArray = np.linspace(0.0, np.pi, CIRCLES)
    return 0.5 - 0.5 * np.cos(angle)


def expand_surface(press: Press, derivatives: Mapping[str, bool]) -> FloatArray:
    """Expand a press and k derivatives: coefficients (1 + k, n increments, `ORDERS`, 3, `CIRCLES`) mm.

    Parameters
    ----------
    press
        Press by a flat wall.
    derivatives
        Names of its derivatives, and whether each breaks the mirror symmetry.
    """
    psi = np.pi * np.arange(_HALF + 1) / _HALF
    azimuth = psi + QUARTER_TURN  # the frame of the mesh
    azimuth += np.deg2rad(press.obstacle.turn_deg) if press.mesh.spec.whole else 0.0
    cosine, sine = np.cos(azimuth), np.sin(azimuth)
    points = surface_points(press.mesh.skin, place_circles(), azimuth).reshape(-1, 3)
    flip = np.array([-1.0, 1.0, 1.0])
    beyond = (points[:, 0] < 0)[:, None] & (not press.mesh.spec.whole)
    places = locate_inner(press.mesh, np.where(beyond, points * flip, points))
    share = np.full(_HALF + 1, 2.0 / _HALF)
    share[[0, -1]] /= 2.0
    order = np.arange(ORDERS)
    even = np.cos(np.outer(psi, order)) * share[:, None] * np.where(order == 0, 0.5, 1.0)
    odd = np.sin(np.outer(psi, order)) * share[:, None]
    fields = [(marker_displacement(press.mesh, places, press.displacement), False)]
    for name, across in derivatives.items():
        rate = press.derivatives[name].displacement
        fields.append(
            (marker_displacement_derivative(press.mesh, places, press.displacement, rate, across=across), across)
        )
    found = []
    for at, across in fields:
        moved = np.where(beyond, at * (-flip if across else flip), at).reshape(len(at), CIRCLES, _HALF + 1, 3)
        radial = moved[..., 0] * cosine + moved[..., 1] * sine
        around = -moved[..., 0] * sine + moved[..., 1] * cosine
        waves, other = (odd, -even) if across else (even, odd)
        series = np.stack([radial @ waves, around @ other, moved[..., 2] @ waves], axis=1)
        found.append(np.moveaxis(series, -1, 1))
    return np.array(found)


def surface_points(skin: Skin, places: FloatArray, azimuths: FloatArray) -> FloatArray:
    """Points (len(places), len(azimuths), 3) mm of the undeformed marked surface."""
    wave = np.stack([np.cos(azimuths), np.sin(azimuths)], axis=-1)
    disc = places[:, None, None] * wave
    return skin.marked(disc.reshape(-1, 2)).reshape(*disc.shape[:2], 3)
