"""Bill of materials of a pack: each part with its size, standard, alternative and source."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from palpate.core.report import Column, Report
from palpate.design import place_orientation_mark
from palpate.fabrication.enclosure import BODIES, ISO_PLATE, LED_HEIGHT, M6_SEAT, SCREWS, SHELF, SLOT, THREAD
from palpate.fabrication.frame import RODS
from palpate.fabrication.mold import DOWEL_DEPTH, DOWEL_DIAMETER, PIN_AZIMUTHS_DEG
from palpate.fabrication.pack import PackContent
from palpate.fabrication.process_sheet import LENGTHS, TAPE, mixing, product_name, ring_screw, screw_length
from palpate.fabrication.spec import ECOFLEX, CameraBody

PLA_DENSITY = 1.24
"""Density of PLA (NatureWorks Ingeo 4043D data sheet), g/mL."""
_BOARD, _M2_NUT = 1.6, 1.6
"""Thickness of a camera board (IPC-2221) and height of an M2 nut (ISO 4032), mm."""
_SENSORS = {CameraBody.DAVIS346: (("DAVIS 346", 6.4),), CameraBody.BOARD28: (("1/4 inch", 3.6), ("1/3 inch", 4.8))}
"""Widths of sensors, mm: 346 pixels of 18.5 µm (iniVation data sheet), and nominal formats."""
_MOUNTS = {CameraBody.DAVIS346: "C or CS mount", CameraBody.BOARD28: "M12 × 0.5 mount"}
CAMERAS = {CameraBody.DAVIS346: "DAVIS 346", CameraBody.BOARD28: "board camera with holes 28 mm apart"}
NAMES = ("number", "part", "quantity", "specification", "alternative", "source")
_PACK, NOT_PRINTED = "geometry", ("window", "rods")
_Row = tuple[str, str, str, str, str]
"""Part, quantity, specification, alternative, source."""


def bill_of_materials(made: PackContent) -> Report:
    """Write the bill of materials of a pack."""
    rows = [*_cast(made), *_markers(made), *_filling(made), *_printed(made), *_optics(made), *_fasteners(made)]
    columns = [Column(name, "no." if name == "number" else "", prose=True) for name in NAMES]
    return Report("", columns, [dict(zip(NAMES, (k, *row), strict=True)) for k, row in enumerate(rows, start=1)])


def _cast(made: PackContent) -> Iterator[_Row]:
    mold, barrel, material = made.mold, made.module.skin.hole, made.design.material
    other = "another silicone whose law was measured (palpate material fit)"
    known = product_name(material)
    source = f"mold and {made.process.excess_percent:g} % excess" + f"; {ECOFLEX}" * ("Smooth-On" in known)
    use = f"{known}. {mixing(material.name, made.mixed)}"
    yield "elastomer", f"{made.mixed:.1f} mL", use, other, source
    yield "filler, lacquer", "1 can each", "sandable filler for plastic; clear acrylic lacquer", "–", "process"
    yield "release agent", "1 can", "for silicone, e.g. Mann Ease Release 200", "soapy water, dried", "process"
    use = f"isopropanol; wet sandpaper P240, P400, P600; polyimide tape of {TAPE:g} mm; film for the cavity"
    yield "consumables", "1 each", use, "–", "process"
    if mold.is_split:
        size = f"{DOWEL_DIAMETER:g} × {2 * DOWEL_DEPTH:g}"
        yield "dowel", "4" if barrel else "3", f"ISO 2338 - {size}, steel", f"steel rod of {size} mm", _PACK
        yield "hose clamp", "3" if barrel else "1", f"DIN 3017, for {2 * mold.radius:.0f} mm", "cable ties", _PACK
    tall = f"opens by {np.ceil(mold.closed_height):.0f} mm or more"
    yield "mold clamp", str(len(PIN_AZIMUTHS_DEG)), tall, "rubber bands", _PACK


def _markers(made: PackContent) -> Iterator[_Row]:
    layout, ink = made.design.layout, made.mold.pins_mm3 / 1000
    if made.module.skin.hole:
        size = f"{ink:.1f} mL fill the dimples; the elastomer with at most 3 % of silicone pigment"
        source = "geometry; Silc Pig bulletin"
        yield "marker silicone", f"{2 * ink:.1f} mL", size, "another contrasting colour", source
        return
    area = len(layout) * np.pi / 4 * layout.diameter**2 / 100
    size = f"silicone ink with hardener, black on an elastomer without pigment; covers {area:.2f} cm²"
    other = "platinum silicone with at most 3 % of pigment"
    yield "ink", "1 set", size, other, "marker area; Smooth-On bulletin, Silc Pig"
    yield "primer", "1 set", "for cured silicone, named by the ink's maker", "corona treatment", "process"
    yield "adhesive tape", "1 roll", "6 to 10 N per 25 mm of width", "–", "ISO 2409"
    if made.artwork is not None and not made.module.skin.pin:
        skin, across = made.design.skin, 2 * made.module.opening_foot
        points = layout.positions[layout.on_dome]
        if made.process.orientation_mark:
            points = np.vstack([points, place_orientation_mark(skin, layout)])
        steep = np.degrees(np.arccos(skin.normal(points)[:, 2].min()))
        size = f"passes the skin's opening ({across:.4g} mm across), reaches its apex {skin.height:g} mm inside, and "
        size += f"prints on walls inclined by up to {steep:.0f}° to the base"
        other = "template.stl (if the pack has it), printed like the mold"
        yield "pad", "1", f"{size}; shape and hardness by the printer's maker", other, _PACK
        text = "artwork.dxf: layers DOTS, MARK and ALIGNMENT, etched as drawn; RIM, the skin's opening, is not etched"
        yield "cliché", "1", text, "–", _PACK


def _filling(made: PackContent) -> Iterator[_Row]:
    if made.window is not None and made.design.material.gel is not None:
        volume = made.window.gel_mm3 / 1000
        amount = f"{volume * (1 + made.process.excess_percent / 100):.1f} mL"
        across, along = 2 * np.abs(made.window.line).max(axis=0)
        use = f"clear {product_name(made.design.material.gel)}; {volume:.2f} mL fill the skin"
        yield "gel", amount, use, "–", _PACK
        size = f"clear PMMA, {across:.4g} × {along:.4g} × {made.window.thickness:g} mm, by window.dxf"
        yield "window", "1", size, "another sheet of the design's refractive index", _PACK


def _printed(made: PackContent) -> Iterator[_Row]:
    for name, solid in {**made.mold.parts, **made.enclosure.parts}.items():
        if name not in NOT_PRINTED:
            volume = solid.volume / 1000
            kind, other = ("PLA", "resin") if name in made.mold.parts else ("PLA, matt black", "PETG, matt black")
            kind += ", two halves in one file" * bool(made.module.skin.hole and name.endswith("ring"))
            size = f"{kind}, {'at most' if name in made.mold.parts else 'solid:'} {volume:.1f} mL, "
            size += f"{PLA_DENSITY * volume:.0f} g at {PLA_DENSITY} g/mL"
            yield name, "1", size, other, "geometry; NatureWorks data sheet"


def _optics(made: PackContent) -> Iterator[_Row]:
    view, kind, body = made.design.camera_spec, made.process.camera_body, BODIES[made.process.camera_body]
    inner, outer = made.led_radii
    size = "white, 5 V, at most 0.5 A, with its own USB cable; flexible, "
    size += f"{LED_HEIGHT:g} mm wide at most, {2 * np.pi * outer:.0f} mm long"
    other = f"ring in two halves, {2 * inner:.1f} to {2 * outer:.1f} mm in diameter, {LED_HEIGHT:g} mm high"
    yield "LED strip", "1", size, other, "geometry; USB 2.0"
    size = f"{body.across[0]:g} × {body.across[1]:g} × {body.depth:g} mm behind the shelf, lens and mount less "
    size += f"than {body.lens:g} mm across"
    pixels = f"{view.width_px} × {view.height_px} px" + ", or more, scaled to it" * (kind is CameraBody.BOARD28)
    yield "camera", "1", f"{CAMERAS[kind]}, {size}, {pixels}", "colour or monochrome", "camera of the design"
    ratio, fisheye = view.fx_px / view.width_px, view.lens == "kannala-brandt"
    lengths = ", ".join(f"{ratio * wide:.2f} mm ({name}, {wide:g} mm wide)" for name, wide in _SENSORS[kind])
    angle = np.degrees(1 / ratio if fisheye else 2 * np.arctan(0.5 / ratio))
    size = f"{'fisheye, ' * fisheye}{_MOUNTS[kind]}, focal length {lengths}, {angle:.0f}° across the width"
    yield "lens", "1", size, "another with this angle", "camera of the design"
    size = f"of the camera; cable and plug pass {SLOT[0]:g} × {SLOT[1]:g} mm; 5 m at most"
    yield "cable", "1", size, "plug fitted later", "geometry; USB 2.0"


def _fasteners(made: PackContent) -> Iterator[_Row]:
    frame, body = made.enclosure.frame, BODIES[made.process.camera_body]
    count, size = 2 * SCREWS if frame else SCREWS, f"{'M2' if frame else 'M3'} × {ring_screw(made.module)[0]}"
    yield "screw, clamp ring", str(count), f"ISO 4762 - {size}, self-cutting", f"ISO 7045 - {size}", _PACK
    size = f"M3 × {screw_length(ISO_PLATE, THREAD)}"
    yield "screw, robot plate", "4", f"ISO 4762 - {size}, self-cutting", f"ISO 7045 - {size}", _PACK
    size = f"M6 × {min(long for long in LENGTHS if long >= M6_SEAT + 6)}"
    text = f"DIN 7984 - {size} (low head), to a flange ISO 9409-1-50-4-M6"
    yield "screw, robot", "4", text, f"ISO 7380-1 - {size}", "geometry; ISO 9409-1"
    text = f"ISO 2338 - 6 m6 × 12, {ISO_PLATE:g} mm of it in the plate"
    yield "dowel, robot", "1", text, "none; turn by eye", "geometry; ISO 9409-1"
    if made.process.camera_body is CameraBody.BOARD28:
        size = f"M2 × {min(long for long in LENGTHS if long >= SHELF + _BOARD + _M2_NUT)}"
        text = f"ISO 4762 - {size} with nut ISO 4032 - M2"
        yield "screw, camera", "4", text, f"ISO 7045 - {size}", "shelf, board (IPC-2221), nut"
    else:
        text = f"of the camera's thread; shelf {SHELF:g} mm, holes {body.screw:g} mm"
        yield "screw, camera", str(len(body.screws)), text, "–", _PACK
    yield "adhesive", "1 tube", "cyanoacrylate gel, for LED strip and dowel", "epoxy", "process"
    if frame:
        yield "rod", str(RODS), f"DIN 976-1 - M5 × {frame.length:.0f}, painted matt black", "stainless steel", _PACK
        yield "nut", str(2 * RODS), "ISO 4032 - M5", "DIN 934 - M5", _PACK
        yield "epoxy, petroleum jelly", "1 each", "for rod sockets; for parting faces of the mold", "–", "process"
