"""Mold: a cavity with the outer surface, closed from above by a core with the inner surface.

Drawn in the position in which it is filled, apex down:

      pour  vents                      core: plate and plug
     __|_|___|__________
    |___ |  __________ _|  <- parting plane, at the foot of the flange
    | | '--'.        .'--' |
    | |pin   '.____.'      |  cavity
    |________________________|

The flange is the highest part of the hollow, so pour hole and vents end on it. Three pins on the cavity are at 30°,
150° and 280°: the mold closes in one position only. The plug and the flange's edge are drafted. A dome that bulges
over its base cannot leave a cavity of one piece: its cavity is split in halves along the axis, held by dowels and a
band. A rib of the cavity casts the notch of the flange. The mold of a pad has the pad's plan, and walls no thinner
than along x; azimuths are angles of the plan.

A barrel's mold stands rim up. Its core extends to the far end, where a spigot centres it in the floor, and is one
piece: segments would leave seams among the dots, and the elastomer bears the stretch of demolding. The dots are
dimples of the core, which are filled with ink before casting.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from palpate.core import PalpateError
from palpate.design import CadSolid, ContactModule, Point, box, cylinder
from palpate.fabrication.flange_key import build_notch
from palpate.fabrication.spec import ProcessSpec

PIN_AZIMUTHS_DEG = (30.0, 150.0, 280.0)
POUR_AZIMUTH_DEG = 90.0
DOWEL_DIAMETER, DOWEL_DEPTH = 2.0, 6.0
"""Diameter and depth of the steel dowels in the halves of a split cavity, mm."""
_BLIND = 0.5
"""Depth of a hole beyond its pin, mm."""
_SPIGOT = 0.6
"""Radius of the spigot at the end of a barrel's core, over that of its opening; the rest seals."""


@dataclass(frozen=True)
class Mold:
    """Mold in the frame of its module, assembled.

    Attributes
    ----------
    module
        The scaled module that fills it.
    parts
        Solids by name: ``mold_core`` and ``mold_cavity``, or the halves of the cavity.
    radius
        Outer radius, mm; half the width along x of a pad's.
    pins_mm3
        Volume of the holes in the core for pins, or of a barrel's dimples, which are filled with ink.
    notch_mm3
        Volume of the notch in the flange.
    """

    module: ContactModule
    parts: dict[str, CadSolid]
    radius: float
    pins_mm3: float = 0.0
    notch_mm3: float = 0.0

    @property
    def spigot(self) -> float:
        """Radius of the spigot at the end of a barrel's core, mm."""
        return _SPIGOT * self.module.opening_radius

    @property
    def closed_height(self) -> float:
        """Height of the closed mold, mm."""
        ends = np.array([part.bounds[:, 2] for part in self.parts.values()])
        return float(ends.max() - ends.min())

    @property
    def is_split(self) -> bool:
        """Whether the cavity is in halves."""
        return len(self.parts) > 2

    def hollow(self) -> float:
        """Return the volume between cavity and core, mm³, which the elastomer fills."""
        return self._hollow

    @cached_property
    def _hollow(self) -> float:
        module = self.module
        wall = module.solid(module.outside()).volume - module.solid(module.inside()).volume
        return wall - self.notch_mm3 + (0.0 if module.skin.hole else self.pins_mm3)


def build_mold(module: ContactModule, spec: ProcessSpec, pins: Sequence[CadSolid] = ()) -> Mold:
    """Build the mold of a module that is already scaled for shrinkage, as its pins are.

    Raises
    ------
    PalpateError
        If pour hole or pins do not fit, or a part exceeds the printer's size.
    """
    flange = float(np.hypot(*module.place(module.flange_foot - module.opening_foot, POUR_AZIMUTH_DEG)))
    if spec.pour_diameter > flange - 2 * spec.printer_wall:
        raise PalpateError(
            f"The pour hole is {spec.pour_diameter:g} mm wide, the flange on which it ends {flange:.3g} mm.",
            f"Use at most {np.floor(100 * (flange - 2 * spec.printer_wall)) / 100:g} mm, or a wider flange.",
            code="pour-hole-too-wide",
        )
    if spec.pin_diameter + 2 * (spec.clearance + spec.printer_wall) > spec.mold_wall:
        raise PalpateError(
            f"A pin of {spec.pin_diameter:g} mm does not fit into a mold wall of {spec.mold_wall:g} mm.",
            f"Use a mold wall of at least {spec.pin_diameter + 2 * (spec.clearance + spec.printer_wall):.3g} mm.",
            code="mold-pin-too-thick",
        )
    if spec.pin_height + _BLIND + spec.printer_wall > spec.plate:
        raise PalpateError(
            f"A pin {spec.pin_height:g} mm high goes through a plate of {spec.plate:g} mm.",
            f"Use a plate of at least {spec.pin_height + _BLIND + spec.printer_wall:.3g} mm.",
            code="mold-pin-too-high",
        )
    widest = module.skin.outer_widest[0]
    radius = max(module.flange_foot, widest if module.skin.hole else 0.0) + spec.mold_wall
    dowel = DOWEL_DIAMETER + 2 * spec.printer_wall
    if module.skin.bulges and min(spec.mold_floor, radius - widest) < dowel:
        raise PalpateError(
            f"The cavity must be split, and its dowels of {DOWEL_DIAMETER:g} mm do not fit into a floor of "
            f"{spec.mold_floor:g} mm.",
            f"Use a floor of at least {dowel:.2g} mm.",
            code="mold-dowels-no-room",
        )
    cavity = _build_cavity(module, spec, radius)
    core = _build_core(module, spec, radius)
    for name, part in (("mold_core", core), ("mold_cavity", cavity)):
        spec.require_room(name, part.bounds)
    whole = core.volume
    if pins:
        core = core.cut(*pins)
    halves = _split(cavity, module, radius, spec) if module.skin.bulges else {"mold_cavity": cavity}
    notch = module.solid().overlap(build_notch(module))
    return Mold(module, {"mold_core": core, **halves}, radius, whole - core.volume, notch)


def _pins(module: ContactModule, spec: ProcessSpec) -> list[Point]:
    middle = module.flange_foot + spec.mold_wall / 2
    return [module.place(middle, azimuth) for azimuth in PIN_AZIMUTHS_DEG]


def _build_cavity(module: ContactModule, spec: ProcessSpec, radius: float) -> CadSolid:
    top = module.top + spec.mold_floor
    block = module.prism(radius, module.foot, top).cut(module.solid(module.outside()))
    if module.skin.hole:
        block = block.cut(cylinder(_SPIGOT * module.opening_radius + spec.clearance, module.top - 1, top + 1))
    root = module.foot + spec.mold_floor / 4
    pins = [cylinder(spec.pin_diameter / 2, module.foot - spec.pin_height, root, at) for at in _pins(module, spec)]
    return block.join(build_notch(module), *pins)


def _build_core(module: ContactModule, spec: ProcessSpec, radius: float) -> CadSolid:
    foot, low = module.foot, module.foot - spec.plate
    core = module.prism(radius, low, foot).join(module.solid(module.inside()))
    if module.skin.hole:
        core = core.join(cylinder(_SPIGOT * module.opening_radius, module.top - 1, module.top + spec.mold_floor))
    hole = spec.pin_diameter / 2 + spec.clearance
    holes = [cylinder(hole, foot - spec.pin_height - _BLIND, foot, at) for at in _pins(module, spec)]
    middle = (module.opening_foot + module.flange_foot) / 2
    pour = cylinder(spec.pour_diameter / 2, low, foot, module.place(middle, POUR_AZIMUTH_DEG))
    vents = [
        cylinder(spec.vent_diameter / 2, low, foot, module.place(middle, azimuth))
        for azimuth in vent_azimuths(spec.vents)
    ]
    return core.cut(*holes, pour, *vents)


def vent_azimuths(count: int) -> list[float]:
    """Return the azimuths of the vents, deg: evenly spaced from the pour hole, once around."""
    return [POUR_AZIMUTH_DEG + 360.0 * (k + 1) / (count + 1) for k in range(count)]


def _split(cavity: CadSolid, module: ContactModule, radius: float, spec: ProcessSpec) -> dict[str, CadSolid]:
    """Split a cavity at y = 0 into halves with holes for dowels, of which one is offset."""
    low, high = module.foot - spec.pin_height, module.top + spec.mold_floor
    across = (module.skin.outer_widest[0] + radius) / 2
    height, offset = module.skin.outer_widest[1], 2 * DOWEL_DIAMETER
    places = [(-across, height), (across, height + offset), (0.0, high - spec.mold_floor / 2)]
    if module.skin.hole:  # a spigot goes through the floor
        places = [
            (-across, height / 3),
            (across, height / 3 + offset),
            (-across, 5 * height / 3),
            (across, 5 * height / 3),
        ]
    dowels = [_dowel(x, z, (DOWEL_DIAMETER + spec.clearance) / 2) for x, z in places]
    margin = 2 * radius
    front = box((-margin, -margin, low - 1), (margin, 0.0, high + 1))
    back = box((-margin, 0.0, low - 1), (margin, margin, high + 1))
    return {
        "mold_cavity_front": cavity.common(front).cut(*dowels),
        "mold_cavity_back": cavity.common(back).cut(*dowels),
    }


def _dowel(x: float, z: float, radius: float) -> CadSolid:
    """Return the hole for a dowel along y about (x, z)."""
    return cylinder(radius, -DOWEL_DEPTH, DOWEL_DEPTH).turned("x", 90.0).moved(x, 0.0, z)
