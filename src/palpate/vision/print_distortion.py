"""Print distortion: size, centre, ellipticity and azimuth of each ring relative to the design.

Pads stretch and skins sag, so a whole print may be distorted although its rings are even. The distortion of the rings
and the camera pose are fitted together to the blobs at rest. Growth of all rings resembles a nearer camera, and a
common offset a camera offset; the priors determine their shares.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from palpate.camera import Camera
from palpate.core import FloatArray
from palpate.design import MarkerLayout, Skin
from palpate.vision.fit_ring import DOT_PX
from palpate.vision.rings import Rings

_SD = (0.08, 0.3, 0.3, 0.03, 0.03, 0.02, 0.03, 0.03)
"""Prior standard deviations of a ring's distortion.

They are those of growth, centre x and y (mm), ellipse (two parameters), rotation, and sliding of its markers along
it, of second order (two parameters): a stretched pad causes sliding, a sagging skin does not. By hand.
"""
_POSE_SD = (4.0, 4.0, 1.0, 5.0, 5.0, 400.0)
"""Prior standard deviations of the camera offset x, y (mm), distance (mm), tilts and roll (degrees).
By hand."""
_FORGIVEN = 5.0
"""Residual over the standard deviation of a marker beyond which the loss is linear. By hand."""
_STEP = 1e-5
"""Step of the finite differences, over the standard deviations. By hand."""


@dataclass(frozen=True, eq=False)
class PrintDistortion:
    """Distortion of a print of rings.

    Attributes
    ----------
    rings
        Ring of each marker.
    radius
        (k,) mean radius of each ring on the skin about its own centre, mm, from the innermost.
    growth
        (k,) radius over that of the design.
    centre
        (k, 2) centre in the base plane, mm.
    flatness, flat_deg
        (k,) ratio of half axes minus one, and the azimuth of the longer one, degrees.
    turn_deg
        (k,) rotation of its markers, degrees.
    positions
        (m, 3) printed position of each marker by this model, mm.
    rms_px
        Root mean square distance of the blobs from the images of these positions.
    """

    rings: Rings
    radius: FloatArray
    growth: FloatArray
    centre: FloatArray
    flatness: FloatArray
    flat_deg: FloatArray
    turn_deg: FloatArray
    positions: FloatArray
    rms_px: float

    @property
    def greatest(self) -> float:
        """Maximum relative deviation of a ring's radius from the design's."""
        return float(np.abs(self.growth - 1.0).max())


def fit_print_distortion(
    rings: Rings,
    design: tuple[MarkerLayout, Skin],
    seen: tuple[NDArray[np.intp], FloatArray],
    posed: Callable[[FloatArray], Camera],
    start: tuple[FloatArray, FloatArray],
) -> tuple[FloatArray, PrintDistortion]:
    """Fit the camera pose (6,) and the distortion of the rings; return both.

    Parameters
    ----------
    rings
        Ring of each marker.
    design
        Layout and skin.
    seen
        Indices (n,) of the markers with a blob, and its pixels (n, 2) corrected for the bias of the ellipse.
    posed
        Returns the camera at a pose of six parameters.
    start
        (6,) initial and nominal pose.
    """
    layout, skin = design
    which, pixels = seen
    prior = np.concatenate([start[1], np.zeros(2 + len(_SD) * len(rings))])
    sd = np.concatenate([_POSE_SD, _SD[1:3], np.tile(_SD, len(rings))])
    first = np.concatenate([start[0], prior[6:]])
    first[2] = start[1][2]

    def miss(values: FloatArray) -> FloatArray:
        places = _printed(rings, layout, skin, values[6:])[which]
        left = np.nan_to_num(posed(values[:6]).project(places) - pixels, nan=1e3)
        return np.concatenate([left.ravel() / DOT_PX, (values - prior) / sd])

    def slopes(values: FloatArray) -> FloatArray:
        """Return finite differences, for all rings at once, as a ring's parameters move its own markers only."""
        base = miss(values)
        found = np.zeros((len(base), len(values)))
        dots = 2 * len(which)
        on_ring = np.repeat(rings.number[which], 2)
        for k in range(8):
            found[:, k] = (miss(values + _STEP * sd[k] * np.eye(len(sd))[k]) - base) / (_STEP * sd[k])
        for k in range(len(_SD)):
            step = np.zeros(len(sd))
            step[8 + k :: len(_SD)] = _STEP * _SD[k]
            change = (miss(values + step) - base) / (_STEP * _SD[k])
            for ring in range(1, len(rings) + 1):
                column = 8 + len(_SD) * (ring - 1) + k
                found[:dots, column] = np.where(on_ring == ring, change[:dots], 0.0)
                found[dots + column, column] = 1.0 / sd[column]
        return found

    fit = least_squares(miss, first, jac=slopes, x_scale=sd, loss="soft_l1", f_scale=_FORGIVEN)
    left = miss(fit.x)[: pixels.size].reshape(-1, 2) * DOT_PX
    rms = float(np.sqrt(np.mean((left**2).sum(axis=1))))
    return fit.x[:6], _law(rings, layout, skin, fit.x[6:], rms)


def _law(rings: Rings, layout: MarkerLayout, skin: Skin, values: FloatArray, rms_px: float) -> PrintDistortion:
    growth, x, y, along, across, turn = values[2:].reshape(len(rings), -1).T[:6]
    flat = np.hypot(along, across)
    return PrintDistortion(
        rings=rings,
        radius=rings.rho[1:] * (1.0 + growth),
        growth=1.0 + growth,
        centre=np.stack([x, y], axis=-1),
        flatness=(1.0 + flat) / (1.0 - flat) - 1.0,
        flat_deg=np.degrees(np.arctan2(across, along)) / 2.0 % 180.0,
        turn_deg=np.degrees(turn),
        positions=_printed(rings, layout, skin, values),
        rms_px=rms_px,
    )


def _printed(rings: Rings, layout: MarkerLayout, skin: Skin, values: FloatArray) -> FloatArray:
    """Return the printed positions (m, 3): two parameters of the centre marker, eight per ring."""
    of_ring = np.vstack([[0.0, *values[:2], *[0.0] * (len(_SD) - 3)], values[2:].reshape(len(rings), -1)])
    growth, x, y, along, across, turn, fro, to = of_ring[rings.number].T
    azimuth = rings.azimuth + turn + fro * np.sin(2.0 * rings.azimuth) + to * np.cos(2.0 * rings.azimuth)
    u, v = (rings.rho[rings.number] * (1.0 + growth) * wave(azimuth) for wave in (np.cos, np.sin))
    px = (1.0 + along) * u + across * v + x
    py = across * u + (1.0 - along) * v + y
    rho = np.minimum(np.hypot(px, py), 0.999 * skin.base_radius)
    return skin.inner_point(rho, np.arctan2(py, px))
