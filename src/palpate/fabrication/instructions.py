"""Workshop sheet: mixing, casting, curing, printing and inspection."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from palpate.core.report import Report, report_markdown
from palpate.design import (
    PRINT_TOLERANCE,
    Finding,
    MarkerLayout,
    Rim,
    Skin,
    place_orientation_mark,
)
from palpate.fabrication.artwork import Artwork, mark_azimuth_deg
from palpate.fabrication.barrel_sheet import (
    barrel_assembly_steps,
    barrel_casting_steps,
    barrel_inspection_steps,
    describe_barrel,
)
from palpate.fabrication.bill_of_materials import CAMERAS, NOT_PRINTED, bill_of_materials
from palpate.fabrication.enclosure import BODIES, SCREWS
from palpate.fabrication.mold import Mold
from palpate.fabrication.pack import PackContent
from palpate.fabrication.process_sheet import (
    ADHESION,
    clamping,
    curing,
    degassing,
    mixing,
    printing_lines,
    ring_screw,
    sprues,
    thickness_tolerance,
    torques,
    volume_line,
)
from palpate.fabrication.spec import PadMapping, ProcessSpec
from palpate.fabrication.window_plate import WindowPlate
from palpate.fabrication.write_artwork import CROSS

_MAPPINGS = {
    PadMapping.AXIS: "along the dome's axis (distance from the axis is kept)",
    PadMapping.ARC: "to equal arcs (distance from the apex along the meridian is kept)",
}


@dataclass(frozen=True)
class Section:
    """Heading with a table or lines, which are numbered if they are steps."""

    title: str
    lines: tuple[str, ...] = ()
    steps: bool = False
    table: Report | None = None


def write_instructions(made: PackContent, findings: Sequence[Finding]) -> list[Section]:
    """Write the sheet of a module."""
    skin, layout, mold, spec = made.module.skin, made.design.layout, made.mold, made.process
    marked, printed = spec.orientation_mark, {**mold.parts, **made.enclosure.parts}
    volume = sum(part.volume for name, part in printed.items() if name not in NOT_PRINTED)
    if made.enclosure.frame is None:
        described = _describe(skin, layout, made.design.material.name, mold)
        measured = _inspect(skin, layout, marked=marked)
        cast = _cast(made)
        marks = [_mark(made, has_template=all(item.code != "no-template" for item in findings))]
    else:
        described = describe_barrel(skin, layout, made.design.material.name, mold, spec)
        cast, measured = barrel_casting_steps(made), barrel_inspection_steps(skin, layout, marked=marked)
        marks = []
    return [
        Section("Contact module", tuple(described)),
        Section("Bill of materials", table=bill_of_materials(made)),
        Section("Print the parts", tuple(printing_lines(skin, spec, volume))),
        Section("Cast", tuple(cast), steps=True),
        *marks,
        *([write_filling(made.window, made.gel, spec)] if made.window else []),
        Section(
            "Inspect",
            (measured[0], volume_line(skin, made.solids["module"], filled=bool(made.window)), *measured[1:]),
        ),
        Section("Enclosure", tuple(_assemble(made)), steps=True),
        Section("Limits", tuple(f"{item.severity}: {item.message} {item.remedy}" for item in findings) or ("None.",)),
    ]


def _describe(skin: Skin, layout: MarkerLayout, material: str, mold: Mold) -> list[str]:
    rim = f" ({skin.rim_thickness:.3g} mm at the rim)" if skin.rim_thickness != skin.thickness else ""
    return [
        f"{skin.shape}: H = {skin.height:g} mm, B = {skin.base_radius:g} mm, T = {skin.thickness:g} mm{rim}, "
        f"inner radius {skin.radius:.5g} mm.",
        f"{len(layout)} markers of {layout.diameter:g} mm "
        f"{f'on pins of {skin.pin:g} mm inside' if skin.pin else 'on the inner surface'}. Elastomer: {material}.",
        f"The mold is larger than the part by the shrinkage of the elastomer "
        f"(factor {mold.module.skin.height / skin.height:.5f}).",
        "Angles are those of the part: counter-clockwise from x, seen from the apex. The artwork and the plan of the "
        "mold show it from its base, so their angles are mirrored: 180° − angle. The plan of the enclosure is not.",
    ]


def _cast(made: PackContent) -> list[str]:
    mold, material, volume = made.mold, made.design.material.name, made.mold.hollow() / 1000
    first = 2 / 3 * volume
    return [
        "Wash and dry hollow and core; spray them with mold release.",
        *(["Join the halves of the cavity on their dowels and tighten the band."] if mold.is_split else []),
        mixing(material, made.mixed),
        degassing(material),
        f"Pour {first:.1f} mL into the cavity, apex down, and set the core in so that the three pins enter: it fits "
        "one way only.",
        f"Pour {volume - first:.1f} mL more through the hole until elastomer stands in every vent. " + clamping(mold),
        "Pour the rest of the cup flat, 2 mm thick: the ink is checked on it.",
        curing(material),
        "Lift the core straight out with the part on it, then peel the part off from the flange.",
        sprues(mold.module, made.process),
    ]


def write_filling(window: WindowPlate, gel: str, spec: ProcessSpec) -> Section:
    """Write the steps that fill a skin with gel and set it on its window."""
    volume = window.gel_mm3 / 1000
    wide, long = 2 * np.abs(window.line).max(axis=0)
    depth = (
        f"its back then lies {window.boss:.3g} mm inside the foot of the flange" if window.boss else "so is its back"
    )
    lines = [
        f"Cut the window, {wide:.4g} mm by {long:.4g} mm, from a clear sheet of {window.thickness:g} mm along "
        "window.dxf; its edges stay square.",
        "Clean its faces with isopropanol. Prime the face for the gel, and the flange's opening, as the gel's maker "
        "recommends: the gel must adhere to window and skin.",
        "Lay the skin back into the cavity, apex down and level: the cavity keeps its shape.",
        f"Mix {volume * (1 + spec.excess_percent / 100):.1f} mL of gel ({gel}) as its maker recommends; draw air out "
        "under vacuum for 5 min.",
        f"Pour it slowly until it stands at the upper edge of the flange's opening ({volume:.2f} mL).",
        "Lower the window into the opening, primed face down and one edge first, so that no bubble is caught, until "
        f"it is flush with the base of the skin; {depth}. Wipe off the excess around it.",
        "Cure level, as the gel's maker recommends; then lift the module out of the cavity.",
    ]
    return Section("Fill with gel", tuple(lines), steps=True)


def _mark(made: PackContent, *, has_template: bool) -> Section:
    skin, layout, spec = made.module.skin, made.design.layout, made.process
    if made.artwork is not None and not skin.pin:
        lines = _print_markers(made, made.artwork, has_template=has_template)
        return Section("Print the markers", tuple(lines), steps=True)
    lines = [
        "Wipe the tips of the pins with isopropanol; let them dry.",
        f"Roll silicone ink of a contrasting colour over the {len(layout)} tips; keep their sides clean.",
        "artwork.pdf shows where the tips are, as seen from the base.",
        *(
            [f"The single pin at {mark_azimuth_deg(skin, layout):.3g}° is the orientation mark: paint it too."]
            if spec.orientation_mark
            else []
        ),
        "Let the ink cure as its maker recommends.",
        ADHESION,
    ]
    return Section("Paint the tips", tuple(lines), steps=True)


def _print_markers(made: PackContent, artwork: Artwork, *, has_template: bool) -> list[str]:
    skin, layout, spec, mold = made.module.skin, made.design.layout, made.process, made.mold
    (across, _), (_, along), *_ = 2 * artwork.crosses
    wide, long = 2 * mold.radius, 2 * mold.module.place(mold.radius, 90.0)[1]
    turn = mark_azimuth_deg(skin, layout)
    outer, inner = across / 2 + CROSS / 2, mold.radius - (spec.mold_wall + spec.pin_diameter) / 2
    size = f"{wide:.4g} mm across" if skin.plan.is_round else f"{wide:.4g} mm by {long:.4g} mm"
    return [
        "Wipe the inner surface with isopropanol; let it dry. Prime it if the ink's maker requires a primer.",
        f"Have the cliché made from artwork.dxf. The pad carries dots {_MAPPINGS[spec.mapping]}; "
        "the artwork is drawn for that, as seen from the base of the dome. Its ellipses "
        f"become round dots of {layout.diameter:g} mm on the dome.",
        "Lay the skin into the cavity, opening up, its notch on the rib: it fits one way only. Print once on a film "
        f"that covers the cavity ({size}), with holes for its three pins. Shift the cavity "
        f"until opposite crosses ({across:.4g} mm and {along:.4g} mm apart) are equally far from the rim of the "
        "hollow to 0.1 mm, the one with the longer arm at the rib. The pad prints between the pins, which begin "
        f"{inner:.4g} mm from the axis: {outer:.4g} mm are enough, and it may miss the end of the longer arm.",
        "Remove the film, and cover the crosses of the cliché with tape: they would print on the foot of the flange. "
        f"Print {len(layout)} dots{' and the orientation mark' if spec.orientation_mark else ''} in one stroke.",
        *(
            [
                "Without a pad printer: set template.stl into the dome, its notch towards that of the "
                "flange, and dab ink through every hole with a foam swab."
            ]
            if has_template
            else []
        ),
        *(
            [
                f"The single dot outside the rings, at {turn:.3g}° in orientation_mark.csv and {180 - turn:.3g}° on "
                "the artwork, is the orientation mark: do not leave it out."
            ]
            if spec.orientation_mark
            else []
        ),
        "Let the ink cure as its maker recommends.",
        ADHESION,
    ]


def _inspect(skin: Skin, layout: MarkerLayout, *, marked: bool) -> list[str]:
    half_way = float(skin.distance(skin.point(np.array([[0.5, 0.0]]), 1.0, Rim.RADIAL))[0]) - skin.pin
    return [
        f"Thickness at the apex {skin.thickness:g} mm, at four places half way down {half_way:.3g} mm, "
        f"± {thickness_tolerance(skin):.2g} mm.",
        f"Inner height over the base: {skin.height:g} ± 0.2 mm.",
        f"All {len(layout)} dots{' and the orientation mark' if marked else ''} present, round to 0.2 mm, separate. "
        f"Places within {PRINT_TOLERANCE:g} mm of markers.csv: measure them under a microscope, or from an image by "
        "`palpate calibration inspect`.",
        "No bubble above 0.5 mm; inner surface matt and even.",
    ]


def _assemble(made: PackContent) -> list[str]:
    enclosure, spec = made.enclosure, made.process
    view = made.design.camera_spec
    wide = [
        size / focal * view.distance for size, focal in ((view.width_px, view.fx_px), (view.height_px, view.fy_px))
    ]
    far = view.distance + made.module.skin.height
    seen = (
        f"Its field of view at the base is {wide[0]:.3g} mm by {wide[1]:.3g} mm. Focus on a target in the place of "
        f"the inner surface, {view.distance:.3g} to {far:.3g} mm from the pinhole, before the module is set on."
    )
    flange = (
        "Set the module's flange on the seat, its notch on the key opposite the cable slot: it fits one way only."
    )
    ring = (
        f"Screw the clamp ring on with {SCREWS} screws M3 × {ring_screw(made.module)[0]}, crosswise. They cut their "
        "own threads."
    )
    check = [_turn_camera(made)] if spec.orientation_mark else []
    window = "The window rests on the boss within the seat: do not press the skin down on it."
    return [
        f"Screw the camera ({CAMERAS[spec.camera_body]}) under the shelf, the screws from below. Its pinhole, inside "
        f"the lens and {BODIES[spec.camera_body].pinhole:g} mm above the lower face of the shelf, is "
        f"{enclosure.camera_distance:g} mm below the base of the {'barrel' if enclosure.frame else 'dome'}. Neither "
        "measure nor adjust it: seat and lens set it. In the built sensor, `palpate calibration camera` measures "
        "the lens and `palpate calibration identify` the distance.",
        *([] if enclosure.frame else [seen]),
        "Pass the strip of LEDs from below through the hole at the edge of the shelf. Glue it to the wall of the "
        "housing directly under the flange, LEDs inward. Lead both cables through the slot.",
        *([window] if made.window else []),
        *([*barrel_assembly_steps(enclosure.frame), *check] if enclosure.frame else [flange, *check, ring]),
        torques(made.module),
        "Screw the robot plate to the robot (ISO 9409-1-50-4-M6, dowel glued into the plate); file its boss until "
        "it enters the robot's flange (31.5 H7). The housing covers these heads later. Then screw the housing to "
        "the plate from the robot's side, outside its flange of 63 mm: the four screws fit one way only, with the "
        "hole of the dowel under the cable slot. For a wrist that is wider than its flange, use a spacer between "
        "robot and plate, as thick as screws and key need.",
    ]


def _turn_camera(made: PackContent) -> str:
    """Write the check of the camera's orientation, which the holes of a square board leave open."""
    view, mark = made.design.camera_spec, place_orientation_mark(made.design.skin, made.design.layout)
    column, row = made.design.camera.project(mark)
    return (
        f"Check the orientation of the camera: in its image of {view.width_px} × {view.height_px} px the orientation "
        f"mark is near column {column:.0f}, row {row:.0f}, counted from the top left. Otherwise take the module off "
        "and screw the camera on again, turned by a quarter or half turn."
    )


def write_markdown(path: Path, sections: Sequence[Section], pictures: Sequence[str]) -> None:
    """Write the sheet as Markdown, with pictures at its end."""
    text = ["# How to make this contact module", ""]
    for section in sections:
        text += [f"## {section.title}", ""]
        marks = [f"{k}. " if section.steps else "* " for k in range(1, len(section.lines) + 1)]
        text += [mark + line for mark, line in zip(marks, section.lines, strict=True)]
        text += [report_markdown(section.table).rstrip()] if section.table else []
        text.append("")
    text += [f"![{Path(name).stem.replace('_', ' ')}]({name})" for name in pictures]
    path.write_text("\n".join(text) + "\n", encoding="utf-8")
