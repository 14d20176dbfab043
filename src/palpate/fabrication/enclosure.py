"""Enclosure: a housing for camera, light and module, a clamp ring, and a robot plate.

          .-''-.
      ___|______|___      clamp ring over the flange, M3 screws
     |_|__________|_|
     | |___    ___| |     strip of LEDs on the wall
     |     \\  /     |
     |      \\/      |     camera's pinhole, `distance` below the base
     |    [camera]  |     shelf that the camera is screwed to
     |______________|
       |___|__|___|       robot plate, ISO 9409-1-50-4-M6

It is round for every skin; opening, recess and opening of the ring, which touch the module, have the module's plan. A
filled skin stands on its window, which rests on a boss of the housing inside the flange. A barrel is clamped at its
far end as well, see `palpate.fabrication.frame`; smaller screws keep its clamps narrower than its bulge.

Camera bodies: the DAVIS 346 is 60 mm x 40 mm x 25 mm without its lens (maker's data sheet); a 28 mm board camera is a
32 mm square board with holes for M2 screws 28 mm apart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.core import PalpateError
from palpate.design import CadSolid, ContactModule, box, cylinder, revolve, rotation_vector, wall_normal
from palpate.fabrication.flange_key import build_key
from palpate.fabrication.frame import CAP_THREAD, BarrelFrame
from palpate.fabrication.spec import CameraBody, ProcessSpec
from palpate.fabrication.window_plate import WindowPlate

WALL, SHELF = 3.0, 4.0
"""Thicknesses of wall and shelf of the housing, mm."""
RING_TOP, RING_EDGE = 1.5, -1.5
"""Height of the clamp ring over the base plane at its opening and its outer edge, mm."""
LED_WIDTH, LED_HEIGHT = 6.0, 4.0
"""Width and height of the space for a strip of LEDs under the flange, around the opening, mm."""
LED_CABLE = 6.0
"""Diameter of the hole in the shelf for the strip of LEDs, on the side of the cable slot, mm."""
SQUEEZE = 0.2
"""Compression of the flange by the clamp ring, mm."""
M3_CORE, M3_CLEAR, M6_CLEAR = 2.5, 3.4, 6.6
"""Diameters of holes, mm: a self-cut M3 thread in plastic, M3 passing, M6 passing (ISO 273, medium)."""
SCREWS = 6
_LAND = 0.5
"""Level width of the clamp ring beyond the corners of an opening that is not round, mm."""
THREAD = 10.0
"""Depth of a self-cut thread, mm."""
_TURNS = 31
"""Number of tested azimuths of a wall, from 0 to 90°; all are equal for a body of revolution."""
ISO_PITCH, ISO_BOSS, ISO_BOSS_HEIGHT, ISO_PIN, ISO_PLATE = 50.0, 31.5, 5.0, 6.0, 8.0
"""Flange 50-4-M6 of ISO 9409-1, mm: pitch circle, centring boss, its height, pin, plate thickness."""
ISO_RADIUS = 31.5
SLOT = (12.0, 8.0)
"""Width and height of the cable slot, mm."""
FIXING_DEG = (45.0, 135.0, 225.0, 305.0)
"""Azimuths of the screws between housing and robot plate."""
M6_SEAT = 4.0
"""Plate under the head of an M6 screw, mm; its recess holds the low head of DIN 7984 (4 mm)."""


@dataclass(frozen=True)
class BodySizes:
    """Dimensions of a camera's body, mm.

    Attributes
    ----------
    across, depth
        Size along x and y, and from front to back.
    lens, pinhole
        Diameter of the hole for the lens and its mount, and distance of the pinhole in front of the body.
    screws, screw
        (x, y) of its screws, and diameter of their holes.
    """

    across: tuple[float, float]
    depth: float
    lens: float
    pinhole: float
    screws: tuple[tuple[float, float], ...]
    screw: float


@dataclass(frozen=True)
class Screw:
    """Screws of a clamp ring, mm: diameters of thread, through hole and head; plastic around them."""

    core: float
    clear: float
    head: float
    clearance: float


M3, M2 = Screw(M3_CORE, M3_CLEAR, 6.2, WALL), Screw(1.6, 2.4, 4.4, 1.8)


def _screw(module: ContactModule) -> Screw:
    return M2 if module.skin.hole else M3


def _corners(x: float, y: float) -> tuple[tuple[float, float], ...]:
    return ((-x, -y), (x, -y), (-x, y), (x, y))


BODIES = {
    CameraBody.DAVIS346: BodySizes((60.0, 40.0), 25.0, 30.0, 14.0, _corners(24.0, 14.0), 2.5),
    CameraBody.BOARD28: BodySizes((32.0, 32.0), 12.0, 22.0, 8.0, _corners(14.0, 14.0), 2.2),
}


@dataclass(frozen=True)
class Enclosure:
    """Parts of an enclosure, assembled, in the frame of the module.

    Attributes
    ----------
    parts
        Solids by name: ``housing``, ``clamp_ring``, ``robot_plate``, ``window`` of a filled skin, and of a barrel
        ``end_ring``, ``end_cap`` and ``rods``.
    camera_distance
        From the pinhole up to the base plane, mm.
    ring
        (radius, z) mm of the edges of the clamp ring that a wall may meet.
    sizes
        Diameters of the holes of housing and robot plate, and of the circles that they are on, as text.
    frame
        Support of the far end of a barrel.
    """

    parts: dict[str, CadSolid]
    camera_distance: float
    ring: tuple[tuple[float, float], ...]
    sizes: tuple[str, str]
    frame: BarrelFrame | None = None


def build_enclosure(
    module: ContactModule,
    camera_distance: float,
    spec: ProcessSpec,
    window: WindowPlate | None = None,
    frame: BarrelFrame | None = None,
) -> Enclosure:
    """Build the enclosure of a module for a camera whose pinhole is `camera_distance` mm below the base.

    `window` is that of a filled skin, `frame` the support of a barrel's far end.

    Raises
    ------
    PalpateError
        If the camera does not fit below the light, or a part exceeds the printer's size.
    """
    body = BODIES[spec.camera_body]
    shelf = -camera_distance - body.pinhole
    room = module.foot - LED_HEIGHT - WALL
    if shelf + SHELF + body.pinhole > room:
        raise PalpateError(
            f"The camera is {camera_distance:g} mm below the base; light and flange extend {-room:g} mm down.",
            f"Use a distance of at least {-room + SHELF:.3g} mm.",
            code="camera-no-room",
        )
    far = module.farthest
    bore = max(far * module.opening_foot + LED_WIDTH, float(np.hypot(*body.across)) / 2 + spec.clearance)
    screw = _screw(module)
    outer = max(bore + WALL, far * module.flange_foot + screw.clear + 2 * screw.clearance, ISO_RADIUS)
    low = shelf - body.depth - WALL
    screws_at = max((bore + outer) / 2, bore + WALL, ISO_RADIUS + M3.head / 2 + spec.clearance)
    base = max(outer, screws_at + M3.clear / 2 + WALL)
    ring = ((_ring_top(module), RING_TOP), (outer, RING_EDGE))
    housing = _housing(module, body, (bore, outer, shelf, low, base, screws_at), window)
    housing = housing.join(build_key(module, spec.clearance))
    parts = {
        "housing": housing if frame is None else housing.join(*frame.posts()).cut(*frame.sockets(spec)),
        "clamp_ring": _clamp_ring(module, spec, outer),
        "robot_plate": _robot_plate(screws_at, base, low),
    }
    for name, part in parts.items():
        spec.require_room(name, part.bounds)
    if window is not None:
        parts["window"] = window.solid
    if frame is not None:
        screws = [cylinder(M2.core / 2, 0.0, CAP_THREAD, at) for at in _screw_places(module, outer)]
        parts |= frame.far_end(parts["clamp_ring"], outer, screws)
    first = float(np.hypot(*_screw_places(module, outer)[0]))
    above = f"screws Ø {screw.core:g}, {THREAD:g} deep, on Ø {2 * first:.4g}"
    below = f"M3: Ø {M3_CLEAR:g} on Ø {2 * screws_at:.4g}; M6: Ø {M6_CLEAR:g} on Ø {ISO_PITCH:g}; "
    below += f"dowel: Ø {ISO_PIN + 0.1:g} on Ø {ISO_PITCH:g}; boss Ø {ISO_BOSS - 0.1:g}"
    return Enclosure(parts, camera_distance, ring, (above, below), frame)


def free_travel(module: ContactModule, enclosure: Enclosure, tilt_deg: float) -> float:
    """Return the depth in mm at which a wall tilted by `tilt_deg` meets the clamp ring.

    It is along the axis; for a barrel, whose wall is tilted towards its nearer end, along the wall's normal.
    """
    tilt = np.radians(tilt_deg)
    if module.skin.hole:
        normal = np.array([np.cos(tilt), 0.0, -np.sin(tilt)])
        return float(module.skin.support_point(normal) @ normal - max(np.array(enclosure.ring) @ normal[::2]))
    turns = rotation_vector(tilt, np.linspace(0.0, np.pi / 2, _TURNS))
    normals = np.array([wall_normal(*turn) for turn in turns.tolist()])
    touch = module.skin.support_height(normals).min()  # of the wall over the axis at first touch
    return float(min(touch - radius * np.tan(tilt) - z for radius, z in enclosure.ring))


def _circle(count: int, radius: float, first_deg: float = 0.0) -> list[tuple[float, float]]:
    angles = np.radians(first_deg) + 2 * np.pi * np.arange(count) / count
    return [(float(radius * np.cos(angle)), float(radius * np.sin(angle))) for angle in angles]


def _fixing_places(radius: float) -> list[tuple[float, float]]:
    """Place the screws of the robot plate, one of them off the square: the housing fits one way only."""
    return [_circle(1, radius, azimuth)[0] for azimuth in FIXING_DEG]


def _housing(
    module: ContactModule, body: BodySizes, sizes: tuple[float, ...], window: WindowPlate | None
) -> CadSolid:
    """Build the tube with flange seat, lip, LED recess and camera shelf, and the foot on the robot plate."""
    bore, outer, shelf, low, base, screws_at = sizes
    seat, lip = module.foot, module.foot - LED_HEIGHT - WALL
    recess = module.farthest * module.opening_foot + LED_WIDTH
    section = [
        (0.0, seat),
        (outer, seat),
        (outer, low + THREAD),
        (base, low + THREAD),
        (base, low),
        (bore, low),
        (bore, lip),
        (recess, lip),
        (recess, seat - WALL),
        (0.0, seat - WALL),
    ]
    tube = revolve(section)
    if window is not None and window.boss > 0:
        tube = tube.join(module.prism(window.reach, seat - WALL / 2, seat + window.boss))
    opening = module.opening_foot if window is None else window.opening
    tube = tube.cut(module.prism(opening, seat - WALL - 1, 0.0))
    plate = cylinder(bore + WALL / 2, shelf, shelf + SHELF)
    tube = tube.join(plate).cut(cylinder(body.lens / 2, shelf - 1, shelf + SHELF + 1))
    holes = [cylinder(body.screw / 2, shelf - 1, shelf + SHELF + 1, at) for at in body.screws]
    holes.append(cylinder(LED_CABLE / 2, shelf - 1, shelf + SHELF + 1, (0.0, bore - 1 - LED_CABLE / 2)))
    core = _screw(module).core / 2
    screws = [cylinder(core, seat - THREAD, seat + 1, at) for at in _screw_places(module, outer)]
    under = [cylinder(M3_CORE / 2, low - 1, low + THREAD, at) for at in _fixing_places(screws_at)]
    cable = box((-SLOT[0] / 2, 0.0, low + WALL), (SLOT[0] / 2, base + 1, low + WALL + SLOT[1]))
    return tube.cut(*holes, *screws, *under, cable)


def _screw_places(module: ContactModule, outer: float) -> list[tuple[float, float]]:
    return _circle(SCREWS, (module.farthest * module.flange_foot + outer) / 2 + 0.25)


def _clamp_ring(module: ContactModule, spec: ProcessSpec, outer: float) -> CadSolid:
    """Build the ring that lies on the housing around the flange and presses on its upper face."""
    edge = module.flange_foot + spec.clearance
    opening = _ring_opening(module)
    section = [
        (0.0, module.foot),
        (outer, module.foot),
        (outer, RING_EDGE),
        (_ring_top(module), RING_TOP),
        (0.0, RING_TOP),
    ]
    room = [
        (0.0, module.foot - 1),
        (edge, module.foot - 1),
        (edge, -SQUEEZE),
        (opening, -SQUEEZE),
        (opening, RING_TOP + 1),
        (0.0, RING_TOP + 1),
    ]
    places, screw = _screw_places(module, outer), _screw(module)
    screws = [cylinder(screw.clear / 2, module.foot - 1, RING_TOP + 1, at) for at in places]
    heads = [cylinder(screw.head / 2, module.foot / 3, RING_TOP + 1, at) for at in places]
    if module.skin.hole:  # in halves, for the skin is wider than its opening
        kerf = (spec.clearance, outer + 1)
        heads.append(box((-kerf[0], -kerf[1], module.foot - 1), (*kerf, RING_TOP + 1)))
    return revolve(section).cut(module.solid(room), *screws, *heads)


def _ring_opening(module: ContactModule) -> float:
    """Return half the clamp ring's opening along x, mm: two fifths of the flange's width beyond the skin."""
    return module.flange_radius - 0.6 * (module.flange_radius - module.widest)


def _ring_top(module: ContactModule) -> float:
    """Return the radius to which the clamp ring is level, mm; that of its opening if round."""
    return module.farthest * _ring_opening(module) + (0.0 if module.skin.plan.is_round else _LAND)


def _robot_plate(screw_radius: float, outer: float, top: float) -> CadSolid:
    """Build the plate of ISO 9409-1-50-4-M6; screws to the housing are outside the robot's flange."""
    plate = cylinder(outer, top - ISO_PLATE, top).join(
        cylinder(ISO_BOSS / 2 - 0.05, top - ISO_PLATE - ISO_BOSS_HEIGHT, top - ISO_PLATE / 2)
    )
    screws = [cylinder(M6_CLEAR / 2, top - ISO_PLATE - 1, top + 1, at) for at in _circle(4, ISO_PITCH / 2, 45.0)]
    heads = [cylinder(5.5, top - ISO_PLATE + M6_SEAT, top + 1, at) for at in _circle(4, ISO_PITCH / 2, 45.0)]
    pin = cylinder(ISO_PIN / 2 + 0.05, top - ISO_PLATE - 1, top + 1, _circle(1, ISO_PITCH / 2, 90.0)[0])
    fixing = [cylinder(M3_CLEAR / 2, top - ISO_PLATE - 1, top + 1, at) for at in _fixing_places(screw_radius)]
    return plate.cut(*screws, *heads, *fixing, pin)
