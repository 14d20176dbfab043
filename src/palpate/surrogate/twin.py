"""Twin: displacement of the inner surface and contact force, for any pose and unit.

Presses at tilts from 0, depths from first contact and frictions from no slip are expanded into Fourier series on
circles (`surface_series`) and reduced to modes (a singular value decomposition of each order). The amplitudes of the
modes are splines over 1/µ, tilt and depth. A tilt of −t is the tilt t rotated by half a turn, so that the spline has
no end at the untilted press. The same modes carry the derivatives of every press by skin thickness, by the obstacle's
curvature, and by its lateral motion and twist during the press.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from palpate.core import FloatArray, IntArray, PalpateError
from palpate.core.state import State
from palpate.design import TILT_SPACE, Skin
from palpate.fea import WallSpec
from palpate.surrogate.circle import QUARTER_TURN
from palpate.surrogate.surface_series import place_circles
from palpate.surrogate.tensor_spline import TensorSpline

TWIN_DERIVATIVES = ("thickness", "curvature", *WallSpec.LATERAL_FIELDS)
"""Derivatives of a twin's presses: by skin thickness, wall curvature, and lateral motion."""
LATERAL = ("lateral_x", "lateral_y", "twist_deg")
"""Lateral motion of a wall in its plane (mm) and twist (degrees) during a press."""
TWIN_STATE = (*TILT_SPACE.names, "inverse_friction", "thickness", "curvature", *LATERAL)
"""Arguments of a twin: pose, 1/µ, thickness deviation (mm), wall curvature (1/m), lateral motion."""
STRAIGHT_DEG = 1e-3
"""Tilt below which a wall counts as untilted; its derivatives are evaluated there. By hand."""
FORCES = 3
"""Number of amplitudes after the modes: force up the slope, along the skin's and tilt's axes, N."""


@dataclass(frozen=True, eq=False)
class Twin:
    """Inner surface of a skin and contact force, for every pose, friction and thickness.

    Attributes
    ----------
    skin
        The skin that was pressed.
    order
        (r,) Fourier order of each mode.
    modes
        (r, 3, n circles) mode in r, φ, z on the circles of `place_circles`; its amplitude is in mm.
    tilts_deg, depths_mm, inverse_frictions
        Grid of the presses, ascending: tilts from 0, depths from rest (0), and 1/µ from no slip (0). Depths of the
        inverted state begin with its existence at all these tilts, and it is the same for every 1/µ.
    max_depth_mm
        (n 1/µ, n tilts) depth that each press reached on its branch.
    amplitudes
        Splines over (1/µ, tilt, depth): those of the press, then derivatives by thickness (mm) and curvature (1/m).
    lateral
        Splines of the derivatives by lateral motion up the slope (mm), along the tilt's axis (mm), and by twist (°).
    material
        Material of the presses, as JSON; empty if the file does not state it.
    inverted
        Twin of the inverted state; `None` if it does not exist, or was not pressed.
    interpolation_error_mm
        RMS difference from presses that it does not contain (`measure_interpolation_error`); nan if not measured.
    left_out
        Names of `TWIN_DERIVATIVES` that its presses cannot have; they are zero in the file, and such changes are
        rejected.
    """

    skin: Skin
    order: IntArray
    modes: FloatArray
    tilts_deg: FloatArray
    depths_mm: FloatArray
    inverse_frictions: FloatArray
    max_depth_mm: FloatArray
    amplitudes: TensorSpline
    lateral: TensorSpline
    material: str = ""
    inverted: Twin | None = None
    interpolation_error_mm: float = float("nan")
    left_out: tuple[str, ...] = ()

    def max_depth(self, tilt_deg: float, inverse_friction: float = 0.0) -> float:
        """Return the minimum depth in mm that the presses next to a tilt and 1/µ reached."""
        i = np.clip(
            np.searchsorted(self.inverse_frictions, inverse_friction), 1, max(len(self.inverse_frictions) - 1, 1)
        )
        j = np.clip(np.searchsorted(self.tilts_deg, tilt_deg), 1, len(self.tilts_deg) - 1)
        rows = self.max_depth_mm[max(i - 1, 0) : i + 1] if len(self.inverse_frictions) > 1 else self.max_depth_mm
        return float(rows[:, j - 1 : j + 1].min())

    def covers(self, pose: FloatArray, slack_deg: float = 0.2, slack_mm: float = 0.05) -> bool:
        """Whether presses reached rx, ry (degrees) and depth (mm), within the tolerances."""
        tilt = float(np.hypot(pose[0], pose[1]))
        deep = self.depths_mm[0] - slack_mm <= pose[2] <= self.max_depth(tilt) + slack_mm
        return bool(tilt <= self.tilts_deg[-1] + slack_deg and deep)

    def with_markers(self, places: FloatArray) -> MarkerTwin:
        """Return the twin of markers at places (m, 3) mm of the undeformed inner surface.

        Raises
        ------
        PalpateError
            If a place is not on the skin.
        """
        if not np.isfinite(places).all():
            raise PalpateError(
                f"{int((~np.isfinite(places).all(axis=1)).sum())} markers are outside the skin.",
                "Leave them out.",
                code="markers-outside-skin",
            )
        disc = self.skin.disc(places)
        along, azimuth = np.hypot(disc[:, 0], disc[:, 1]), np.arctan2(disc[:, 1], disc[:, 0])
        spline = CubicSpline(place_circles(), np.moveaxis(self.modes, -1, 0))
        return MarkerTwin(self, places, along, azimuth, self._waves(spline(along), azimuth))

    def _waves(self, shapes: FloatArray, azimuth: FloatArray) -> FloatArray:
        """Return waves (3 m, 2 r) of modes of shapes (m, r, 3) at the azimuths (m,) of the markers.

        The pattern of a tilt at azimuth α is that of azimuth 0 rotated: ``cos k(φ - α - 90°)``.
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


class MarkerState(NamedTuple):
    """Marker positions at one pose, with derivatives.

    Attributes
    ----------
    positions
        (m, 3) mm.
    jacobian
        (m, 3, 6 or 9): mm over the entries of `TWIN_STATE`; those of `LATERAL` only with a motion.
    force
        (3,) N on the wall, skin's frame.
    force_jacobian
        (3, 6 or 9) derivatives of the force.
    amplitudes
        (2 r,) of the waves, which also move other printed points (`MarkerTwin.positions_at`).
    """

    positions: FloatArray
    jacobian: State
    force: FloatArray
    force_jacobian: State
    amplitudes: FloatArray


@dataclass(frozen=True, eq=False)
class MarkerTwin:
    """Twin of one marker layout.

    Attributes
    ----------
    twin
        Twin of the skin.
    places
        (m, 3) mm, undeformed markers.
    meridian, azimuth
        (m,) place on the meridian of the unit disc, and about the axis, rad.
    waves
        (3 m, 2 r) displacement by the modes' amplitudes times cos kα and times sin kα of the tilt's azimuth α.
    """

    twin: Twin
    places: FloatArray
    meridian: FloatArray
    azimuth: FloatArray
    waves: FloatArray

    def evaluate(
        self,
        pose: FloatArray,
        inverse_friction: float,
        thickness: float = 0.0,
        lateral: FloatArray | None = None,
        curvature: float = 0.0,
    ) -> MarkerState:
        """Evaluate the marker positions under a wall.

        Parameters
        ----------
        pose
            (3,) rx, ry (degrees) and depth (mm), up to just beyond the presses.
        inverse_friction
            1/µ.
        thickness
            Deviation of the skin thickness, mm.
        lateral
            (3,) lateral motion of the obstacle during the press in its plane, in x and y (mm, axes rotated with the
            wall), and twist about its normal (degrees); zero by default.
        curvature
            Curvature of the wall, 1/m; positive if it bulges towards the skin.

        Raises
        ------
        PalpateError
            If the twin leaves out a change that is not 0.
        """
        if self.twin.left_out:
            refuse_left_out(self.twin, (thickness, curvature, *(np.zeros(3) if lateral is None else lateral)))
        tilt, azimuth = max(float(np.hypot(pose[0], pose[1])), STRAIGHT_DEG), float(np.arctan2(pose[1], pose[0]))
        even, odd = self._parts(
            np.array([inverse_friction, tilt, float(pose[2])]), (thickness, curvature), azimuth, lateral
        )
        order, modes, count = self.twin.order[:, None], len(self.twin.order), even.shape[1] - 1
        cos, sin = np.cos(order * azimuth), np.sin(order * azimuth)
        rows = np.empty((2 * modes, count + 1))
        rows[:modes], rows[modes:] = even[:modes] * cos, even[:modes] * sin
        if odd is not None:
            rows[:modes] -= odd[:modes] * sin
            rows[modes:] += odd[:modes] * cos
        rows[:modes, count] -= order[:, 0] * rows[modes:, 0]
        rows[modes:, count] += order[:, 0] * rows[:modes, 0]
        moved = (self.waves @ rows).reshape(-1, 3, count + 1)
        force = _turn_force(even[modes:] if odd is None else even[modes:] + odd[modes:], azimuth)
        by, force_by = np.empty((len(moved), 3, count)), np.empty((3, count))
        c, s = np.cos(azimuth), np.sin(azimuth)
        for out, each in ((by, moved), (force_by, force)):
            around = each[..., count]
            out[..., 0] = each[..., 1] * c - around * (s / tilt)
            out[..., 1] = each[..., 1] * s + around * (c / tilt)
            out[..., 2:] = each[..., 2:count]
        names = TWIN_STATE[:count]
        return MarkerState(
            self.places + moved[..., 0], State(names, by), force[:, 0], State(names, force_by), rows[:, 0]
        )

    def positions_at(self, amplitudes: FloatArray) -> FloatArray:
        """Return the marker positions (m, 3) mm for amplitudes (2 r,) of the waves."""
        return np.asarray(self.places + (self.waves @ amplitudes).reshape(-1, 3))

    def _parts(
        self, place: FloatArray, made: tuple[float, float], azimuth: float, drift: FloatArray | None
    ) -> tuple[FloatArray, FloatArray | None]:
        """Amplitudes of modes and force (r + 3, n): parts that keep and parts that break the mirror symmetry.

        `place` is (1/µ, tilt, depth); `made` are the deviations of thickness and curvature. Columns: value;
        derivatives by tilt, depth, 1/µ, thickness, curvature and, with a lateral motion, x, y and twist; by the
        azimuth of the wall at constant lateral motion.
        """
        twin = self.twin
        found = twin.amplitudes.evaluate(place)
        half = found.shape[1] // 3
        pressed, thicker, bent = found[:, :half], found[:, half : 2 * half], found[:, 2 * half :]
        even = np.zeros((half, 7 if drift is None else 10))
        even[:, [0, 3, 1, 2]] = (pressed + made[0] * thicker + made[1] * bent).T
        even[:, 4], even[:, 5] = thicker[0], bent[0]
        if drift is None:
            return even, None
        odd, (c, s) = np.zeros_like(even), (np.cos(azimuth), np.sin(azimuth))
        up, across, twist = twin.lateral.evaluate(place).reshape(4, 3, half).transpose(1, 2, 0)
        along, aside = drift[1] * c - drift[0] * s, drift[0] * c + drift[1] * s
        even[:, [0, 3, 1, 2]] += along * up
        odd[:, [0, 3, 1, 2]] = aside * across + drift[2] * twist
        even[:, 6], even[:, 7], even[:, 9] = -s * up[:, 0], c * up[:, 0], -aside * up[:, 0]
        odd[:, 6], odd[:, 7], odd[:, 8], odd[:, 9] = (
            c * across[:, 0],
            s * across[:, 0],
            twist[:, 0],
            along * across[:, 0],
        )
        return even, odd


def refuse_left_out(twin: Twin, changes: Sequence[float]) -> None:
    """Raise a `PalpateError` if a twin leaves out a nonzero change, of those by `TWIN_DERIVATIVES`."""
    asked = [
        name for name, change in zip(TWIN_DERIVATIVES, changes, strict=False) if change and name in twin.left_out
    ]
    if asked:
        raise PalpateError(
            f"The twin of {twin.skin.name} has no derivative by {asked[0]}, and a change of it was asked for.",
            f"Set the tolerance of {asked[0]} to 0, or solve presses of the changed design.",
            code="twin-derivative-left-out",
        )


def _turn_force(parts: FloatArray, azimuth: float) -> FloatArray:
    """Force (3, n) N from its parts up the slope, along the axes of skin and tilt; the last by azimuth."""
    c, s = np.cos(azimuth), np.sin(azimuth)
    slope, axial, axis = parts
    force = np.stack([axis * c - slope * s, slope * c + axis * s, axial])
    force[:2, -1] += [-slope[0] * c - axis[0] * s, axis[0] * c - slope[0] * s]
    return force
