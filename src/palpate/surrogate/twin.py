"""The twin: where every point of the inner surface goes, and what the wall bears, for any pose and any unit.

Presses at tilts from 0 on, at depths from first touch on, under frictions from no slip on, are expanded into Fourier
series on circles (`surface_series`), reduced to the modes in which they differ (a singular value decomposition of
each order), and the amplitudes of these modes are splines over 1/µ, tilt and depth. A tilt of −t is the tilt t turned
by half a turn, which gives the spline no end at the straight press. The derivative of every press by the
thickness of its wall is carried in the same modes, and so are those by the obstacle's curvature, and by how far it
has travelled sideways and turned on its way down.
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
"""Derivatives of a twin's presses: by the skin's thickness, the wall's curvature, and its lateral motion."""
LATERAL = ("lateral_x", "lateral_y", "twist_deg")
"""Travel of a wall in its plane (mm) and its turn (degrees) on the way down."""
TWIN_STATE = (*TILT_SPACE.names, "inverse_friction", "thickness", "curvature", *LATERAL)
"""Pose, 1/µ, change of thickness (mm), curvature of the wall (1/m) and its motion: the arguments of a twin."""
STRAIGHT_DEG = 1e-3
"""Tilt below which a wall counts as straight; its derivatives are taken there."""
FORCES = 3
"""Amplitudes after those of the modes: force up the wall's slope, along the dome's axis, and along the tilt's, N."""


@dataclass(frozen=True, eq=False)
class Twin:
    """A skin's inner surface and the force on the wall, for every pose, friction and thickness.

    Attributes
    ----------
    skin
        The design that was pressed.
    order
        (r,) Fourier order of each mode.
    modes
        (r, 3, n circles) mode in r, φ, z on the circles of `place_circles`; its amplitude is in mm.
    tilts_deg, depths_mm, inverse_frictions
        What was pressed, rising: tilts from 0, depths from rest (0), and 1/µ from no slip (0). Of the inverted state
        depths begin where it stands under all these tilts, and it is the same for every 1/µ.
    max_depth_mm
        (n slips, n tilts) depth that each press reached on its branch.
    amplitudes
        Splines over (slip, tilt, depth): those of the press, then their derivatives by thickness (mm) and bend (1/m).
    lateral
        Splines likewise of the derivatives by drift up the slope (mm), along the tilt's axis (mm), and by twist (°).
    material
        What was pressed, as JSON; empty in files that do not say.
    inverted
        The twin of the skin's other state; `None` where it has none, or it was not pressed.
    interpolation_error_mm
        Root mean square by which it differs from presses between its own (`measure_interpolation_error`); nan without
        any.
    left_out
        Names of `TWIN_DERIVATIVES` that its presses cannot have; it has zeros in their place, and refuses such
        changes.
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
        """Depth in mm to which the presses about a tilt and 1/µ got: the least of the neighbours."""
        i = np.clip(
            np.searchsorted(self.inverse_frictions, inverse_friction), 1, max(len(self.inverse_frictions) - 1, 1)
        )
        j = np.clip(np.searchsorted(self.tilts_deg, tilt_deg), 1, len(self.tilts_deg) - 1)
        rows = self.max_depth_mm[max(i - 1, 0) : i + 1] if len(self.inverse_frictions) > 1 else self.max_depth_mm
        return float(rows[:, j - 1 : j + 1].min())

    def covers(self, pose: FloatArray, slack_deg: float = 0.2, slack_mm: float = 0.05) -> bool:
        """Whether presses reached rx, ry (degrees) and depth (mm), or nearly so."""
        tilt = float(np.hypot(pose[0], pose[1]))
        deep = self.depths_mm[0] - slack_mm <= pose[2] <= self.max_depth(tilt) + slack_mm
        return bool(tilt <= self.tilts_deg[-1] + slack_deg and deep)

    def with_markers(self, places: FloatArray) -> MarkerTwin:
        """The twin of dots at places (m, 3) mm of the undeformed inner surface.

        Raises
        ------
        PalpateError
            If a place is not on the skin.
        """
        if not np.isfinite(places).all():
            raise PalpateError(
                f"{int((~np.isfinite(places).all(axis=1)).sum())} dots lie outside the dome.",
                "Leave them out.",
                code="markers-outside-skin",
            )
        disc = self.skin.disc(places)
        along, azimuth = np.hypot(disc[:, 0], disc[:, 1]), np.arctan2(disc[:, 1], disc[:, 0])
        spline = CubicSpline(place_circles(), np.moveaxis(self.modes, -1, 0))
        return MarkerTwin(self, places, along, azimuth, self._waves(spline(along), azimuth))

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


class MarkerState(NamedTuple):
    """Where dots are at one pose, and how that changes.

    Attributes
    ----------
    positions
        (m, 3) mm.
    jacobian
        (m, 3, 6 or 9): mm over the entries of `TWIN_STATE`; those of `LATERAL` only with a motion.
    force
        (3,) N on the wall, dome's frame.
    force_jacobian
        (3, 6 or 9) the same.
    amplitudes
        (2 r,) of the waves: what else is printed on the skin moves by them as well (`MarkerTwin.positions_at`).
    """

    positions: FloatArray
    jacobian: State
    force: FloatArray
    force_jacobian: State
    amplitudes: FloatArray


@dataclass(frozen=True, eq=False)
class MarkerTwin:
    """The twin of one print.

    Attributes
    ----------
    twin
        Of the skin.
    places
        (m, 3) mm, undeformed dots.
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
        """Dots under a wall.

        Parameters
        ----------
        pose
            (3,) rx, ry (degrees) and depth (mm), or just beyond what was pressed.
        inverse_friction
            1/µ.
        thickness
            By how much the dome's wall is thicker, mm.
        lateral
            (3,) how far the obstacle has travelled on the way down in its own plane, in x and y (mm, axes turned
            with the wall), and its twist about its normal (degrees). Without it, there is none.
        curvature
            Its curvature, 1/m; positive where it bulges towards the dome.

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
        """Where the dots are (m, 3) mm as the waves have these amplitudes (2 r,)."""
        return np.asarray(self.places + (self.waves @ amplitudes).reshape(-1, 3))

    def _parts(
        self, place: FloatArray, made: tuple[float, float], azimuth: float, drift: FloatArray | None
    ) -> tuple[FloatArray, FloatArray | None]:
        """Amplitudes of modes and force (r + 3, n) that keep and that break the mirror symmetry of the tilt.

        At a place (slip, tilt, depth) of a dome so much thicker and a wall so much bent as they are `made`. Their
        columns: value; over tilt, depth, slip, thickness, bend and, with drift, x, y and twist; over the azimuth of
        the wall while the drift stays.
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
    """Raise a `PalpateError` if a twin leaves out a change, of those by `TWIN_DERIVATIVES`, that is not 0."""
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
    """Force (3, n) N from its parts up the slope, along the dome's axis and the tilt's; the last over the azimuth."""
    c, s = np.cos(azimuth), np.sin(azimuth)
    slope, axial, axis = parts
    force = np.stack([axis * c - slope * s, slope * c + axis * s, axial])
    force[:2, -1] += [-slope[0] * c - axis[0] * s, axis[0] * c - slope[0] * s]
    return force
