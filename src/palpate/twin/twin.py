"""The twin: where every point of the inner surface goes, and what the wall bears, for any pose and any unit.

Presses at tilts from 0 on, at depths from first touch on, under frictions from no slip on, are expanded into Fourier
series on circles (`surface_series`), reduced to the modes in which they differ (a singular value decomposition of
each order), and the amplitudes of these modes are splines over 1/µ, tilt and depth. A tilt of −t is the tilt t turned
by half a turn, which gives the spline no end at the straight press. The derivative of every press by the
thickness of its wall is carried in the same modes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from palpate.core import FloatArray, IntArray, PalpateError
from palpate.design import Skin
from palpate.twin.circle import QUARTER_TURN
from palpate.twin.surface_series import place_circles
from palpate.twin.tensor_spline import TensorSpline

STRAIGHT_DEG = 1e-3
"""Tilt below which a wall counts as straight; its derivatives are taken there."""
FORCES = 2
"""Amplitudes after those of the modes: force across the wall's tilt and along the dome's axis, N."""


class Amplitudes(NamedTuple):
    """Amplitudes at one pose, of modes and force.

    Attributes
    ----------
    value, by_tilt, by_depth, by_slip, by_thickness
        (r + 2,) mm and N, and derivatives over a degree, mm, 1/µ, and mm of thickness.
    """

    value: FloatArray
    by_tilt: FloatArray
    by_depth: FloatArray
    by_slip: FloatArray
    by_thickness: FloatArray


@dataclass(frozen=True, eq=False)
class Twin:
    """A skin's inner surface and the force on the wall, for every pose, friction and thickness.

    Attributes
    ----------
    skin
        The design that was pressed.
    order
        (r,) Fourier order of each mode.
    shapes
        (r, 3, n circles) mode in r, φ, z on the circles of `place_circles`; its amplitude is in mm.
    tilts_deg, depths_mm, slips
        What was pressed, rising: tilts from 0, depths from rest (0), and 1/µ from no slip (0).
    reach_mm
        (n slips, n tilts) depth that each press reached on the flat branch.
    amplitudes
        Splines over (slip, tilt, depth): first those of the press, then their derivative by the thickness.
    """

    skin: Skin
    order: IntArray
    shapes: FloatArray
    tilts_deg: FloatArray
    depths_mm: FloatArray
    slips: FloatArray
    reach_mm: FloatArray
    amplitudes: TensorSpline

    def at(self, tilt_deg: float, depth_mm: float, slip: float, thickness: float = 0.0) -> Amplitudes:
        """Amplitudes at a tilt, depth and 1/µ, or just beyond what was pressed, in a wall thicker by some mm."""
        found = self.amplitudes.evaluate(np.array([slip, tilt_deg, depth_mm]))
        half = found.shape[1] // 2
        value, by_slip, by_tilt, by_depth = found[:, :half] + thickness * found[:, half:]
        return Amplitudes(value, by_tilt, by_depth, by_slip, found[0, half:])

    def reach(self, tilt_deg: float, slip: float = 0.0) -> float:
        """Depth in mm to which the presses about a tilt and 1/µ got: the least of the neighbours."""
        i = np.clip(np.searchsorted(self.slips, slip), 1, max(len(self.slips) - 1, 1))
        j = np.clip(np.searchsorted(self.tilts_deg, tilt_deg), 1, len(self.tilts_deg) - 1)
        rows = self.reach_mm[max(i - 1, 0) : i + 1] if len(self.slips) > 1 else self.reach_mm
        return float(rows[:, j - 1 : j + 1].min())

    def covers(self, pose: FloatArray, slack_deg: float = 0.2, slack_mm: float = 0.05) -> bool:
        """Whether presses reached rx, ry (degrees) and depth (mm), or nearly so."""
        tilt = float(np.hypot(pose[0], pose[1]))
        return tilt <= self.tilts_deg[-1] + slack_deg and pose[2] <= self.reach(tilt) + slack_mm

    def print_dots(self, places: FloatArray) -> PrintedTwin:
        """The twin of dots at places (m, 3) mm of the undeformed inner surface.

        Raises
        ------
        PalpateError
            If a place is not on the skin.
        """
        if not np.isfinite(places).all():
            raise PalpateError(
                f"{int((~np.isfinite(places).all(axis=1)).sum())} dots lie outside the dome.", "Leave them out."
            )
        disc = self.skin.disc(places)
        along, azimuth = np.hypot(disc[:, 0], disc[:, 1]), np.arctan2(disc[:, 1], disc[:, 0])
        spline = CubicSpline(place_circles(), np.moveaxis(self.shapes, -1, 0))
        return PrintedTwin(self, places, along, azimuth, self._waves(spline(along), azimuth))

    def _waves(self, shapes: FloatArray, azimuth: FloatArray) -> FloatArray:
        """Waves (3 m, 2 r) of modes that have these shapes (m, r, 3) at the azimuths (m,) of the dots.

        The pattern of a tilt at azimuth α is that of azimuth 0 turned: ``cos k(φ - α - 90°)``.
        """
        angle = self.order * (azimuth[:, None] - QUARTER_TURN)
        cos, sin = np.cos(angle), np.sin(angle)
        radial, around, axial = np.moveaxis(shapes, -1, 0)
        ways = (
            np.stack([radial * cos, around * sin, axial * cos]),
            np.stack([radial * sin, -around * cos, axial * sin]),
        )
        c, s = np.cos(azimuth)[:, None], np.sin(azimuth)[:, None]
        turned = [np.stack([r * c - f * s, r * s + f * c, z], axis=1) for r, f, z in ways]
        return np.ascontiguousarray(np.concatenate(turned, axis=-1).reshape(-1, 2 * len(self.order)))


class MovedDots(NamedTuple):
    """Where dots are at one pose, and how that changes.

    Attributes
    ----------
    positions
        (m, 3) mm.
    by
        (m, 3, 5): mm over a degree of rx, of ry, mm of depth, 1/µ, and mm of thickness.
    force
        (3,) N on the wall, dome's frame.
    force_by
        (3, 5) the same.
    """

    positions: FloatArray
    by: FloatArray
    force: FloatArray
    force_by: FloatArray


@dataclass(frozen=True, eq=False)
class PrintedTwin:
    """The twin of one print.

    Attributes
    ----------
    twin
        Of the skin.
    places
        (m, 3) mm, undeformed dots.
    along, azimuth
        (m,) place on the meridian of the unit disc, and about the axis, rad.
    waves
        (3 m, 2 r) displacement by the modes' amplitudes times cos kα and times sin kα of the tilt's azimuth α.
    """

    twin: Twin
    places: FloatArray
    along: FloatArray
    azimuth: FloatArray
    waves: FloatArray

    def move(self, pose: FloatArray, slip: float, thickness: float = 0.0) -> MovedDots:
        """Dots at rx, ry (degrees) and depth (mm), under a friction of 1/µ = `slip`, in a wall thicker by some mm."""
        rx, ry, depth = (float(value) for value in pose)
        tilt, azimuth = max(float(np.hypot(rx, ry)), STRAIGHT_DEG), float(np.arctan2(ry, rx))
        order = self.twin.order
        cos, sin = np.cos(order * azimuth), np.sin(order * azimuth)
        modes = len(order)
        rows = np.empty((2 * modes, 6))
        a = np.stack(self.twin.at(tilt, depth, slip, thickness), axis=1)
        rows[:modes, :5], rows[modes:, :5] = a[:modes] * cos[:, None], a[:modes] * sin[:, None]
        rows[:modes, 5], rows[modes:, 5] = -a[:modes, 0] * order * sin, a[:modes, 0] * order * cos
        moved = (self.waves @ rows).reshape(-1, 3, 6)
        force, turn = self._force(a[modes:], azimuth)
        by, force_by = np.empty((len(moved), 3, 5)), np.empty((3, 5))
        for out, each, around in ((by, moved, moved[..., 5]), (force_by, force, turn)):
            c, s = np.cos(azimuth), np.sin(azimuth)
            out[..., 0] = each[..., 1] * c - around * (s / tilt)
            out[..., 1] = each[..., 1] * s + around * (c / tilt)
            out[..., 2:] = each[..., 2:5]
        return MovedDots(self.places + moved[..., 0], by, force[:, 0], force_by)

    def amplitudes(self, pose: FloatArray, slip: float, thickness: float) -> FloatArray:
        """Amplitudes (2 r,) of the waves at a pose."""
        order, tilt = self.twin.order, float(np.hypot(pose[0], pose[1]))
        value = self.twin.at(tilt, float(pose[2]), slip, thickness).value[: len(order)]
        angle = order * float(np.arctan2(pose[1], pose[0]))
        return np.concatenate([value * np.cos(angle), value * np.sin(angle)])

    @staticmethod
    def _force(parts: FloatArray, azimuth: float) -> tuple[FloatArray, FloatArray]:
        """Force (3, n) N from its parts (2, n) across and along the axis, and its derivative (3,) over a rad."""
        c, s = np.cos(azimuth), np.sin(azimuth)
        across, along = parts
        return np.stack([-s * across, c * across, along]), np.array([-c * across[0], -s * across[0], 0.0])
