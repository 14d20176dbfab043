"""The frame of a barrel: four rods inside the skin carry the cap on which its far end is clamped.

        ___________________
    ====|=================|==   end cap; a nut on either side of it on every rod
     |_ |  _            _ | _|  end ring, the clamp ring again
       )|                 |(
      / |                 | \\   rods of 5 mm, between the columns of dots
       )|                 |(
     |--|--            ---|--|  clamp ring
    ====[]==          ===[]===  housing: sockets beside its opening, that rods are glued into

The camera stands on the axis, so a rod along the axis hides the plane through both from it and no more: at an azimuth
without dots it hides none. A clear tube would carry more, but bends the flat lines of sight to the far rows by
millimetres, which no lens here knows; and outside the skin a rod would be in the way of what it touches.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.design import CadSolid, ContactModule, MarkerLayout, box, cylinder, gather
from palpate.fabrication.spec import ProcessSpec

ROD, RODS = 5.0, 4
"""Diameter (M5 threaded rod, mm) and number of the rods."""
NUT, NUT_HEIGHT, ROD_CLEAR = 8.8, 4.7, 5.5
"""Corners and height of an M5 nut, and the hole that a rod passes (ISO 4032, ISO 273 medium), mm."""
CAP, CAP_THREAD = 8.0, 7.0
"""Thickness of the end cap, and depth in it of the threads of the end ring's screws, mm."""
SCREW_LENGTH = 8.0
"""Length of the rings' M2 screws, mm: 2 mm of ring under the head, the rest within `CAP_THREAD`."""
POST, SOCKET = 4.2, 10.0
"""Radius of a socket's wall and its depth under the seat of the flange, mm."""
_FLOOR, _GAP, _LUG, _END = 1.0, 0.8, 3.0, 2.0
"""Floor of a socket; gap of a socket and the skin; height of what holds a socket; rod beyond the outer nut, mm."""


@dataclass(frozen=True)
class BarrelFrame:
    """Rods, cap and sockets of a barrel, in the frame of its module.

    Attributes
    ----------
    module
        The module.
    azimuths
        Of the rods, rad.
    """

    module: ContactModule
    azimuths: tuple[float, ...]

    @property
    def circle(self) -> float:
        """Distance of the rods from the axis, mm."""
        return self.module.opening_radius - _GAP - max(POST, NUT / 2)

    @property
    def places(self) -> FloatArray:
        """(4, 2) mm."""
        return self.circle * np.column_stack([np.cos(self.azimuths), np.sin(self.azimuths)])

    @property
    def ends(self) -> tuple[float, float]:
        """Heights of the rods' ends, mm."""
        return self.module.foot - SOCKET + _FLOOR, self.module.top + CAP + NUT_HEIGHT + _END

    @property
    def length(self) -> float:
        """Of a rod, mm."""
        return self.ends[1] - self.ends[0]

    def posts(self) -> list[CadSolid]:
        """Sockets within the flange's opening, and what holds them to the housing."""
        foot, reach = self.module.foot, self.module.opening_foot + 1.0
        lug = box((self.circle, -POST, foot - _LUG), (reach, POST, foot))
        found = []
        for azimuth, (x, y) in zip(self.azimuths, self.places.tolist(), strict=True):
            found += [lug.turned("z", float(np.degrees(azimuth))), cylinder(POST, foot - SOCKET, 0.0, (x, y))]
        return found

    def sockets(self, spec: ProcessSpec) -> list[CadSolid]:
        """The holes that rods are glued into."""
        return self._along(ROD / 2 + spec.clearance / 2, self.ends[0], 1.0)

    def far_end(self, ring: CadSolid, outer: float, screws: Sequence[CadSolid]) -> dict[str, CadSolid]:
        """The cap, (mm) so far from the axis and with threads for screws, the ring turned over, and the rods."""
        low = self.module.top
        cap = cylinder(outer, low, low + CAP).cut(
            *self._along(ROD_CLEAR / 2, low - 1, low + CAP + 1), *(screw.moved(z=low) for screw in screws)
        )
        rods = gather(self._along(ROD / 2, *self.ends))
        return {"end_ring": ring.turned("x", 180.0).moved(z=self.module.skin.height), "end_cap": cap, "rods": rods}

    def _along(self, radius: float, low: float, high: float) -> list[CadSolid]:
        return [cylinder(radius, low, high, (x, y)) for x, y in self.places.tolist()]

    def hidden(self, origin: FloatArray, points: FloatArray) -> FloatArray:
        """Which (n,) of points (n, 3) mm rods or sockets hide from a pinhole at `origin` (3,) mm."""
        found = np.zeros(len(points), bool)
        low, high = self.module.foot - SOCKET, self.ends[1]
        for radius, top in ((POST, 0.0), (ROD / 2, high)):
            rise = points[:, 2] - origin[2]
            begin, end = (np.clip((z - origin[2]) / rise, 0.0, 1.0)[:, None] for z in (low, top))
            start, way = origin[:2] + begin * (points - origin)[:, :2], (end - begin) * (points - origin)[:, :2]
            for place in self.places:
                square = np.maximum((way**2).sum(axis=1), 1e-12)
                share = np.clip(((place - start) * way).sum(axis=1) / square, 0.0, 1.0)[:, None]
                found |= np.linalg.norm(start + share * way - place, axis=1) < radius
        return found


def plan_frame(module: ContactModule, layout: MarkerLayout) -> BarrelFrame:
    """Place the rods of a barrel where the dots leave the widest sectors next to 45°, 135°, 225° and 315°.

    Raises
    ------
    PalpateError
        If there is no room for them.
    """
    least = 2 * POST + _GAP + max(POST, NUT / 2)
    if module.opening_radius < least:
        raise PalpateError(
            f"The barrel opens by {module.opening_radius:g} mm at its ends: four rods that carry the far end leave "
            "no view.",
            f"Take a radius of at least {least:.3g} mm there.",
            code="frame-no-view",
        )
    azimuths = np.unique(np.arctan2(layout.positions[:, 1], layout.positions[:, 0]).round(6))
    gaps = np.diff(azimuths, append=azimuths[0] + 2 * np.pi)
    widest = gaps > gaps.max() - 1e-3
    middles = (azimuths + gaps / 2)[widest]
    chosen = []
    for wanted in np.pi / 4 + np.arange(RODS) * 2 * np.pi / RODS:
        away = np.abs((middles - wanted + np.pi) % (2 * np.pi) - np.pi)
        chosen.append(float(middles[away < away.min() + 1e-3][-1]))
    return BarrelFrame(module, tuple(chosen))
