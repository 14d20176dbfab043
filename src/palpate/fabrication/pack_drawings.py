"""Drawings of a pack: sections of module, mold and enclosure, views along the axis, and parts."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from palpate.design import CadSolid, ContactModule, box, gather
from palpate.fabrication.drawing_sheet import Plan, Sheet, draw_bodies, draw_cut, draw_plans
from palpate.fabrication.enclosure import FIXING_DEG, SCREWS, Enclosure
from palpate.fabrication.flange_key import NOTCH_AZIMUTH_DEG, build_notch, notch_radius
from palpate.fabrication.mold import PIN_AZIMUTHS_DEG, POUR_AZIMUTH_DEG, Mold, vent_azimuths
from palpate.fabrication.pack import PackContent
from palpate.fabrication.spec import ProcessSpec

_SILICONE, _PLASTIC, _CORE, _GEL, _GLASS = "#e8c9a8", "#8fa8c8", "#b8c9de", "#f6ecdf", "#dbe8ec"
_COLOURS = {"mold_core": _CORE, "housing": _CORE, "window": _GLASS, "robot_plate": _GLASS, "end_cap": _GLASS}
"""Colours of parts; others are `_PLASTIC`."""
_CABLE_DEG, _FIXING_DEG = 90.0, 225.0
"""Azimuths of the enclosure's section: cable slot and hole of the strip; screw of the robot plate."""
_BETWEEN, _FAR = 30.0, 1e4
"""Space between two sections, mm of the page, and half the edge of a box that is cut away, mm."""
TURNED = ("mold_cavity", "mold_cavity_front", "mold_cavity_back", "end_ring", "end_cap", "robot_plate")
"""Parts that are printed upside down."""


def draw_pack(made: PackContent, numbers: dict[str, int]) -> dict[str, Figure]:
    """Draw the pages of a pack by file name; `numbers` are those of the bill of materials by part."""
    mold, enclosure, module = made.mold, made.enclosure, made.module

    def call(name: str) -> str:
        return f"{numbers[name]}  {_name(name)}" if name in numbers else _name(name)

    parts = sorted(enclosure.parts.items(), key=lambda item: -item[1].bounds[:, 2].mean())
    body = made.solids["module"]
    return {
        "module_section": draw_module_section(made),
        "mold_section": draw_mold_section(mold, made.process),
        "mold_plan": _draw_mold_plan(mold, made.process),
        "mold_parts": draw_bodies([(call(name), _as_printed(name, part)) for name, part in mold.parts.items()]),
        "enclosure_section": draw_enclosure_section(module, enclosure, body),
        "enclosure_plan": _draw_enclosure_plan(enclosure),
        "enclosure_parts": draw_bodies([("contact module", body), *((call(name), part) for name, part in parts)]),
    }


def _name(part: str) -> str:
    return part.removeprefix("mold_").replace("_", " ")


def _as_printed(name: str, part: CadSolid) -> CadSolid:
    """Turn a part as it lies on the bed of the printer."""
    return part.turned("x", 180.0) if name in TURNED else part


def draw_module_section(made: PackContent) -> Figure:
    """Draw the section of a module with its dimensions; a filled one with gel and window."""
    module, window = made.module, made.window
    skin, foot, wide = module.skin, module.foot, module.flange_foot
    half = max(wide, skin.outer_widest[0])
    sheet = Sheet.around((-half, foot - 14.0), (half, module.top))
    unit = sheet.unit
    parts = {"module": (made.solids["module"], _SILICONE)}
    if window is not None:
        gel = [(0.0, skin.height), *skin.meridian(0.0, down=True), (0.0, 0.0)]
        parts = {"gel": (module.solid(gel), _GEL), "window": (window.solid, _GLASS), **parts}
        sheet.write((0.0, 3 * unit), f"gel; window {window.thickness:g}")
    turns = (NOTCH_AZIMUTH_DEG, NOTCH_AZIMUTH_DEG - 180.0) if skin.plan.is_round else (0.0, 180.0)
    draw_cut(sheet, parts, turns)
    for level, reach, text in ((8, skin.base_radius, "2 B = "), (16, wide, "")):
        y = foot - level * unit
        sheet.dimension((-reach, y), (reach, y), f"{text}{2 * reach:.4g}", foot)
    side, top = half + 6 * unit, skin.height + skin.thickness
    sheet.dimension((side, 0.0), (side, skin.height), f"H = {skin.height:.4g}", 0.0 if not skin.hole else wide)
    sheet.dimension((side, foot), (side, 0.0), f"{module.flange_thickness:.4g}", wide)
    if skin.hole:
        middle, reach = skin.height / 2, skin.widest[0]
        sheet.dimension((-reach, middle), (reach, middle), f"{2 * reach:.4g}")
        sheet.write((reach, middle + 8 * unit), f"T = {skin.thickness:.4g} ", "right")
    else:
        sheet.dimension((0.0, skin.height), (0.0, top), "")
        sheet.write((0.0, top + 3 * unit), f"T = {skin.thickness:.4g}")
    text = f"right: section at {turns[0]:g}°, through the notch R {notch_radius(module):.3g}"
    if not skin.plan.is_round:
        text = f"section along x; along y {skin.plan.stretch:.4g} times as long"
    text += f"; draft {made.mount.draft_deg:g}°"
    if not skin.hole:
        text += f"; inner radius {'at the apex' if skin.plan.is_round else 'of the edge'} {skin.radius:.4g}"
    sheet.write((0.0, foot - 24 * unit), text)
    return sheet.figure


def draw_mold_section(mold: Mold, spec: ProcessSpec) -> Figure:
    """Draw two sections of the closed mold as it is filled, apex down: pour hole and pin, vent and rib."""
    module, radius, floor, plate = mold.module, mold.radius, spec.mold_floor, spec.plate
    foot, top = module.foot, module.top + floor
    body = module.solid().cut(build_notch(module))
    parts = {"elastomer": (body, _SILICONE)}
    parts |= {_name(name): (part, _COLOURS.get(name, _PLASTIC)) for name, part in mold.parts.items()}
    tall = top - foot + plate
    reach = max(float(np.hypot(*module.place(radius, azimuth))) for azimuth in (*PIN_AZIMUTHS_DEG, POUR_AZIMUTH_DEG))
    sheet = Sheet.around((-reach, -top - tall), (reach, plate - foot), _BETWEEN)
    unit = sheet.unit
    step = tall + _BETWEEN * unit
    pour, pin, vent = POUR_AZIMUTH_DEG, PIN_AZIMUTHS_DEG[1], vent_azimuths(spec.vents)[0]
    cuts = (
        (pour, f"pour hole Ø {spec.pour_diameter:g}", pin, f"pin Ø {spec.pin_diameter:g}"),
        (vent, f"vent Ø {spec.vent_diameter:g}", NOTCH_AZIMUTH_DEG, f"rib R {notch_radius(module):.3g}"),
    )
    for k, (first, right, second, left) in enumerate(cuts):
        polar = [float(np.degrees(np.arctan2(*module.place(1.0, azimuth)[::-1]))) for azimuth in (first, second)]
        anchors = draw_cut(sheet, parts, (polar[0], polar[1]), (-1.0, -k * step))
        sheet.names(anchors, -reach - 4 * unit)
        text = f"left: {left} at {second:.4g}°\nright: {right} at {first:.4g}°"
        sheet.write((0.0, -top - k * step - 4 * unit), text, up="top")
    side, inner = reach + 6 * unit, -module.skin.height
    sheet.dimension((side, -top), (side, -foot), f"{top - foot:.4g}", reach)
    sheet.dimension((side, -foot), (side, -foot + plate), f"{plate:.4g}", reach)
    sheet.dimension((side, -top - step), (side, -top + floor - step), f"{floor:.4g}", reach)
    sheet.dimension((side, inner - step), (side, -foot - step), f"core {-foot - inner:.4g}", 0.0)
    low, along = -top - step - 24 * unit, "" if module.skin.plan.is_round else " along x"
    sheet.dimension((-radius, low), (radius, low), f"{2 * radius:.4g}{along}")
    return sheet.figure


def draw_enclosure_section(module: ContactModule, enclosure: Enclosure, body: CadSolid) -> Figure:
    """Draw the assembled enclosure cut open, with its dimensions; `body` is the module's."""
    parts = enclosure.parts
    housing, plate, ring = (parts[name].bounds for name in ("housing", "robot_plate", "clamp_ring"))
    low, seat = float(plate[0, 2]), module.foot
    high = max(float(part.bounds[1, 2]) for part in (body, *parts.values()))
    side = float(max(housing[1, 0], plate[1, 0]))
    sheet = Sheet.around((-side, low), (side, high))
    unit = sheet.unit
    left = _FIXING_DEG if enclosure.frame is None else float(np.degrees(enclosure.frame.azimuths[2])) % 360
    solids = {"contact module": (body, _SILICONE)}
    solids |= {_name(name): (part, _COLOURS.get(name, _PLASTIC)) for name, part in parts.items()}
    anchors = draw_cut(sheet, solids, (_CABLE_DEG, left), behind=True)
    pinhole = -enclosure.camera_distance
    sheet.axis.plot(0.0, pinhole, "k+", markersize=8)
    sheet.names({**anchors, "pinhole": np.array([0.0, pinhole])}, -side - 4 * unit)
    for (start, end), level in ((ring[:, 0], high + 5 * unit), (plate[:, 0], low - 8 * unit)):
        sheet.dimension((start, level), (end, level), f"Ø {end - start:.4g}")
    for x, start, end in ((6, low, plate[1, 2]), (6, plate[1, 2], seat), (18, low, high)):
        sheet.dimension((side + x * unit, start), (side + x * unit, end), f"{end - start:.4g}")
    sheet.dimension((2 * unit, pinhole), (2 * unit, 0.0), f"{-pinhole:.4g}")
    second = "rods" if enclosure.frame else "screw of the robot plate"
    sheet.write((0.0, low - 14 * unit), f"right: {_CABLE_DEG:g}°, cable slot; left: {left:.4g}°, {second}", up="top")
    return sheet.figure


def _draw_mold_plan(mold: Mold, spec: ProcessSpec) -> Figure:
    plate = mold.parts["mold_core"].cut(box((-_FAR, -_FAR, mold.module.foot), (_FAR, _FAR, _FAR)))
    cavity = gather([part for name, part in mold.parts.items() if name != "mold_core"])
    pins = [(azimuth, "pin") for azimuth in PIN_AZIMUTHS_DEG]
    vents = [(azimuth % 360, "vent") for azimuth in vent_azimuths(spec.vents)]
    above, module = (*vents, (POUR_AZIMUTH_DEG, "pour")), mold.module
    middle = (module.opening_foot + module.flange_foot) / 2
    holes = f"pour hole Ø {spec.pour_diameter:g} and vents Ø {spec.vent_diameter:g}{_on(middle, module)}"
    core = Plan("core on the closed mold, from above", holes, plate, above, module)
    sizes = f"pins Ø {spec.pin_diameter:g}{_on(module.flange_foot + spec.mold_wall / 2, module)}"
    wide = Plan("cavity, into its opening", sizes, cavity, (*pins, (NOTCH_AZIMUTH_DEG, "rib")), module)
    return draw_plans([core, wide])


def _on(reach: float, module: ContactModule) -> str:
    """Name the circle of features, or their distances along x and y for a plan that is not round."""
    x, y = module.place(reach, 0.0)[0], module.place(reach, 90.0)[1]
    return f" on Ø {2 * reach:.4g}" if module.skin.plan.is_round else f", {x:.4g} along x or {y:.4g} along y"


def _draw_enclosure_plan(enclosure: Enclosure) -> Figure:
    ring = [(360.0 * k / SCREWS, "screw") for k in range(SCREWS)]
    above, below = enclosure.sizes
    plate = [(azimuth, "M3") for azimuth in FIXING_DEG] + [(azimuth, "M6") for azimuth in (45.0, 135.0, 225.0, 315.0)]
    return draw_plans(
        [
            Plan(
                "housing, from the skin",
                above,
                enclosure.parts["housing"],
                (*ring, (90.0, "cable"), (NOTCH_AZIMUTH_DEG, "key")),
            ),
            Plan("robot plate, from the housing", below, enclosure.parts["robot_plate"], (*plate, (90.0, "dowel"))),
        ]
    )
