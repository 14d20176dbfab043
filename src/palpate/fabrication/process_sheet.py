"""Lines of the workshop sheet on 3-D printing, roughness, clamping, sprues, adhesion and screws."""

from __future__ import annotations

from math import ceil, exp, log, pi, sqrt

from palpate.design import CadSolid, ContactModule, Skin, box
from palpate.fabrication.enclosure import ISO_PLATE, M6_CLEAR, SQUEEZE, THREAD, WALL
from palpate.fabrication.frame import CAP_THREAD
from palpate.fabrication.mold import PIN_AZIMUTHS_DEG, Mold
from palpate.fabrication.spec import ECOFLEX, ProcessSpec
from palpate.material import Material, get_material

_DENSITY, _BULLETIN = 1.07, "ecoflex_00_30"
"""Density of Ecoflex 00-30, g/mL, and part of its names in the library (source: `ECOFLEX`)."""
_PRODUCTS = {
    "zaid_2024_ecoflex_00_30": "Smooth-On Ecoflex 00-30",
    "marechal_2020_ecoflex_00_30": "Smooth-On Ecoflex 00-30",
    "marechal_2020_ecoflex_00_50": "Smooth-On Ecoflex 00-50",
    "marechal_2020_dragon_skin_10": "Smooth-On Dragon Skin 10",
    "marechal_2020_dragon_skin_30": "Smooth-On Dragon Skin 30",
}
"""Products whose laws the library has, by the name of the law."""
NOZZLE, LAYER, RESIN_LAYER, _SPEED = 0.4, 0.1, 0.05, 60.0
"""Nozzle and layers of a filament and a resin printer, mm, and speed of the nozzle, mm/s."""
TAPE = 0.05
"""Thickness of the tape that fills the gap around the pins, mm."""
LENGTHS = (5, 6, 8, 10, 12, 16, 20, 25, 30)
"""Nominal lengths of ISO 4762 and DIN 7984, mm."""
_SPARE, _M6_HEAD = 1.0, 10.0
"""Free depth below the end of a screw, and diameter of an M6 head (DIN 7984), mm."""
_BOND, _SAFETY, _COEFFICIENT = 17.0, 2.0, 0.2
"""PLA between layers, MPa (Prusament PLA data sheet: 17 ± 3); safety; torque coefficient (dry steel)."""
ADHESION = (
    "Check adhesion on the excess elastomer, cast flat and marked alike: press on a tape of 6 to 10 N per 25 mm and "
    "pull it off at about 60° within 1 s (ISO 2409). No marker may come off, or crack when stretched; otherwise "
    "prime the surface, or use another primer."
)


def thickness_tolerance(skin: Skin) -> float:
    """Return the tolerance of the thickness, mm."""
    return max(0.05, 0.05 * skin.thickness)


def screw_length(grip: float, depth: float) -> int:
    """Return the longest standard screw (mm) that does not reach the bottom of a thread, mm."""
    return max(length for length in LENGTHS if length <= grip + depth - _SPARE)


def ring_screw(module: ContactModule) -> tuple[int, float]:
    """Return length and grip of the clamp ring's screws, mm, which also fit a barrel's end cap."""
    grip = 2 / 3 * module.flange_thickness
    return screw_length(grip, CAP_THREAD if module.skin.hole else THREAD), grip


def thread_torque(diameter: float, engaged: float) -> float:
    """Return the torque of a screw in PLA, N·m, at half the load that strips half its flanks."""
    return _COEFFICIENT * diameter * 0.5 * pi * diameter * engaged * _BOND / sqrt(3) / _SAFETY / 1000


def printing_lines(skin: Skin, spec: ProcessSpec, parts_mm3: float) -> list[str]:
    """Write how the parts, of a volume in all, are printed and their surface is finished."""
    halves = "halves of the cavity upright, with support only in the recess next to the floor"
    web = (spec.mold_wall - spec.pin_diameter - 2 * spec.clearance) / 2
    return [
        f"Filament printer (FDM): nozzle of {NOZZLE:g} mm, layers of {LAYER:g} mm. Mold: {ceil(web / NOZZLE)} walls "
        "and 2 mm of solid layers around an infill of 20 % or more, so that pins and hollow are in solid material. "
        f"Enclosure: {ceil(WALL / 2 / NOZZLE)} walls, infill 100 % for its threads. Core with its plate "
        f"on the bed; {halves if skin.hole else 'cavity with its opening up'}. The parts of the bill lie in their "
        "files as they are printed; the enclosure needs support under its overhangs. At "
        f"{_SPEED:g} mm/s all of them take up to {parts_mm3 / (NOZZLE * LAYER * _SPEED) / 3600:.0f} h. Other files "
        "(module, window, rods) are not printed.",
        f"Resin printer (SLA, MSLA), for the mold only: layers of {RESIN_LAYER:g} mm, solid. Wash and post-cure it "
        "as the resin's maker recommends, then seal it with clear acrylic lacquer: uncured resin inhibits platinum "
        f"silicone ({ECOFLEX}).",
        f"Roughness of core and hollow: Rz {100 * thickness_tolerance(skin):.2g} µm or less (ISO 21920-2), a tenth "
        f"of the tolerance of the thickness. Layers leave steps of up to {1000 * LAYER:g} µm, or "
        f"{1000 * RESIN_LAYER:g} µm of resin. Sand off half a layer ({LAYER / 2:g} mm, resin {RESIN_LAYER / 2:g} "
        "mm), fill the grooves with sandable filler, and sand wet with P240, P400 and P600 (ISO 6344). Then seal "
        "core and hollow with clear acrylic lacquer: filler may inhibit platinum silicone.",
        "Measure Rz on the plate of the core, finished alike, with a tester or a comparison specimen.",
        f"The pins have a gap of {spec.clearance:g} mm, more than a thin skin tolerates: wind tape of {TAPE:g} mm "
        f"around each, some {ceil(spec.clearance / TAPE)} turns, until the core is centred and still lifts by hand.",
    ]


def product_name(material: Material) -> str:
    """Return the name under which an elastomer is sold, or its stiffness and the closest of the library."""
    if material.name in _PRODUCTS:
        return f"{_PRODUCTS[material.name]} (law {material.name})"
    apart = {name: log(get_material(name).young_modulus / material.young_modulus) for name in _PRODUCTS}
    near = min(apart, key=lambda name: abs(apart[name]))
    modulus = 1000 * material.young_modulus
    return (
        f"silicone with a Young's modulus of {modulus:.{0 if modulus > 99 else 1}f} kPa (law {material.name}); the "
        f"closest product of the library, {_PRODUCTS[near]}, has {exp(apart[near]):.2g} times this modulus"
    )


def mixing(material: str, mixed: float) -> str:
    """Write how a volume (mL) of an elastomer is mixed; figures are those of Ecoflex 00-30."""
    if _BULLETIN not in material:
        return f"Mix {mixed:.1f} mL of {material} as its maker states, and observe its pot life."
    half = f"{mixed / 2:.2f} mL"
    return f"Mix part A {half} and part B {half} slowly for 3 min. Pot life 45 min at 23 °C."


def degassing(material: str) -> str:
    """Write how the mixed elastomer is degassed, with the pressure of the bulletin of Ecoflex 00-30."""
    much = " of 98 kPa below ambient (29 inHg)" if _BULLETIN in material else ""
    return f"Draw air out under a vacuum{much} for 5 min, in a cup with space for the foam."


def curing(material: str) -> str:
    """Write how long the elastomer cures."""
    return f"Cure {'for 4 h at 23 °C' if _BULLETIN in material else 'as its maker states'} on a level table."


def clamping(mold: Mold) -> str:
    """Write how the filled mold is clamped, against the buoyancy of its core."""
    pins = ", ".join(f"{azimuth:g}°" for azimuth in PIN_AZIMUTHS_DEG)
    lift = 9.81e-6 * _DENSITY * mold.module.solid(mold.module.inside()).volume
    return (
        f"Clamp core and cavity at the three pins ({pins}). The elastomer (some {_DENSITY:g} g/mL) lifts the core "
        f"with {lift:.2g} N in all: clamps only close the parting plane; more force bends the plate."
    )


def volume_line(skin: Skin, body: CadSolid, *, filled: bool) -> str:
    """Write how the thickness of a module is measured without denting it, before it is filled."""
    far = 10 * skin.height + 10 * skin.base_radius
    top = skin.height if skin.hole else far
    wall = body.cut(box((-far, -far, -far), (far, far, 0.0)), box((-far, -far, top), (far, far, far + 1)))
    allowed = thickness_tolerance(skin) / skin.thickness * wall.volume
    return "Before the gel is poured: " * filled + (
        "A gauge dents the elastomer: focus a microscope on the inner and the outer surface, or cut a spare part. "
        "Volume by weighing in air and in water, without sprues: "
        f"{body.volume / 1000:.4g} mL ± {allowed / 1000:.2g} mL."
    )


def sprues(module: ContactModule, spec: ProcessSpec) -> str:
    """Write how the sprues are cut."""
    middle = (module.opening_foot + module.flange_foot) / 2
    along = "" if module.skin.plan.is_round else " along x"
    return (
        f"Cut the sprues with a blade flat on the foot of the flange: one of {spec.pour_diameter / 2:g} mm radius "
        f"and {spec.vents} of {spec.vent_diameter / 2:g} mm, {middle:.4g} mm from the axis{along}. Leave at most "
        f"{SQUEEZE / 2:g} mm, half the squeeze of the flange, and no nick: the foot is the seat."
    )


def torques(module: ContactModule) -> str:
    """Write the squeeze of the flange and the torques of the screws."""
    thread, (length, grip), thick = 2 if module.skin.hole else 3, ring_screw(module), module.flange_thickness
    plate = thread_torque(3, screw_length(ISO_PLATE, THREAD) - ISO_PLATE)
    robot = _COEFFICIENT * 6 * _BOND * pi / 4 * (_M6_HEAD**2 - M6_CLEAR**2) / _SAFETY / 1000
    return (
        f"The clamp ring lies on the housing without a gap and then compresses the flange by {SQUEEZE:g} mm, from "
        f"{thick:g} to {thick - SQUEEZE:g} mm. Beyond the torque that cuts the thread, tighten its M{thread} screws "
        f"by at most {thread_torque(thread, length - grip):.2f} N·m, those of the robot plate by {plate:.2f} N·m, "
        f"M6 into the robot by {robot:.2f} N·m (PLA, {_BOND:g} MPa between layers, Prusament data sheet; safety "
        f"{_SAFETY:g})."
    )
