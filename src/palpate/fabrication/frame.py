"""Frame of a barrel: four rods inside the skin carry the cap that clamps its far end.

        ___________________
    ====|=================|==   end cap; a nut on either side of it on every rod
     |_ |  _            _ | _|  end ring, the clamp ring again
       )|                 |(
      / |                 | \\   rods of 5 mm, between the columns of dots
       )|                 |(
     |--|--            ---|--|  clamp ring
    ====[]==          ===[]===  housing: sockets next to its opening, for glued rods

The camera is on the axis, so a rod parallel to it hides only its own azimuth, which is chosen between the dots. A
clear tube would be stiffer, but refracts the flat lines of sight to the far rows by millimetres, which no lens model
here describes; a rod outside the skin would obstruct the contact.
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
"""Width across corners and height of an M5 nut, and clearance hole of a rod (ISO 4032, ISO 273), mm."""
CAP, CAP_THREAD = 8.0, 7.0
"""Thickness of the end cap, and depth of the threads for the end ring's screws, mm."""
POST, SOCKET = 4.2, 10.0
"""Outer radius of a socket, and its depth under the seat of the flange, mm."""
_FLOOR, _GAP, _LUG, _END = 1.0, 0.8, 3.0, 2.0
"""Floor of a socket, gap to the skin, height of a lug, and rod beyond the outer nut, mm."""


@dataclass(frozen=True)
class BarrelFrame:
    """Rods (by azimuth, rad), cap and sockets of a barrel, in the frame of its module."""

    module: ContactModule
    azimuths: tuple[float, ...]

    @property
    def circle(self) -> float:
        """Distance of the rods from the axis, mm."""
        return self.module.opening_radius - _GAP - max(POST, NUT / 2)

    @property
    def places(self) -> FloatArray:
        """Positions (4, 2) of the rods, mm."""
        return self.circle * np.column_stack([np.cos(self.azimuths), np.sin(self.azimuths)])

    @property
    def ends(self) -> tuple[float, float]:
        """Heights of the rods' ends, mm."""
        return self.module.foot - SOCKET + _FLOOR, self.module.top + CAP + NUT_HEIGHT + _END

    @property
    def length(self) -> float:
        """Length of a rod, mm."""
        return self.ends[1] - self.ends[0]

    def posts(self) -> list[CadSolid]:
        """Build the sockets inside the flange's opening, and their lugs to the housing."""
        foot, reach = self.module.foot, self.module.opening_foot + 1.0
        lug = box((self.circle, -POST, foot - _LUG), (reach, POST, foot))
        found = []
        for azimuth, (x, y) in zip(self.azimuths, self.places.tolist(), strict=True):
            found += [lug.turned("z", float(np.degrees(azimuth))), cylinder(POST, foot - SOCKET, 0.0, (x, y))]
        return found

    def sockets(self, spec: ProcessSpec) -> list[CadSolid]:
        """Build the holes of the sockets."""
        return self._along(ROD / 2 + spec.clearance / 2, self.ends[0], 1.0)

    def far_end(self, ring: CadSolid, outer: float, screws: Sequence[CadSolid]) -> dict[str, CadSolid]:
        """Build end cap (radius `outer`, mm; threads at `screws`), end ring and rods."""
        low = self.module.top
        cap = cylinder(outer, low, low + CAP).cut(
            *self._along(ROD_CLEAR / 2, low - 1, low + CAP + 1), *(screw.moved(z=low) for screw in screws)
        )
        rods = gather(self._along(ROD / 2, *self.ends))
        return {"end_ring": ring.turned("x", 180.0).moved(z=self.module.skin.height), "end_cap": cap, "rods": rods}

    def _along(self, radius: float, low: float, high: float) -> list[CadSolid]:
        return [cylinder(radius, low, high, (x, y)) for x, y in self.places.tolist()]

    def hidden(self, origin: FloatArray, points: FloatArray) -> FloatArray:
        """Return which points (n, 3) mm rods or sockets hide from a pinhole at `origin` (3,) mm."""
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
    """Place the rods of a barrel in the widest sectors without dots near 45°, 135°, 225° and 315°.

    Raises
    ------
    PalpateError
        If the opening is too small for them.
    """
    least = 2 * POST + _GAP + max(POST, NUT / 2)
    if module.opening_radius < least:
        raise PalpateError(
            f"The barrel opens by {module.opening_radius:g} mm at its ends: four rods for the far end would block "
            "the view.",
            f"Use a radius of at least {least:.3g} mm there.",
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
