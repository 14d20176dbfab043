"""Workshop sheet in Markdown and as PDF: mixing, casting, curing, printing and inspection."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_pdf import PdfPages
from matplotlib.figure import Figure

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
from palpate.fabrication.bill_of_materials import CAMERAS, bill_of_materials
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
)
from palpate.fabrication.spec import PadMapping, ProcessSpec
from palpate.fabrication.window_plate import WindowPlate

_LINES, _WIDTH = 58, 92
"""Lines of a page of text and characters of a line."""
_CELLS = (4, 18, 11, 48, 28, 24)
"""Characters of the columns of a table."""
_A4 = (8.27, 11.69)
"""Width and height of a page, inches."""
_DRAWING_DPI, _ON_A_PAGE = 200, 3
"""Resolution and number of the drawings on a page."""
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
    if made.enclosure.frame is None:
        described = _describe(skin, layout, made.design.material.name, mold)
        measured = _inspect(skin, layout, marked=spec.orientation_mark)
        cast = _cast(made)
        marks = [_mark(made, has_template=all(item.code != "no-template" for item in findings))]
    else:
        described = describe_barrel(skin, layout, made.design.material.name, mold, spec)
        cast, measured = barrel_casting_steps(made), barrel_inspection_steps(skin, layout)
        marks = []
    return [
        Section("Contact module", tuple(described)),
        Section("Bill of materials", table=bill_of_materials(made)),
        Section("Print the parts", tuple(printing_lines(skin, spec))),
        Section("Cast", tuple(cast), steps=True),
        *marks,
        *([write_filling(made.window, made.gel, spec)] if made.window else []),
        Section("Inspect", tuple(measured)),
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
    size = f"{wide:.4g} mm across" if skin.plan.is_round else f"{wide:.4g} mm by {long:.4g} mm"
    return [
        "Wipe the inner surface with isopropanol; let it dry. Prime it if the ink's maker requires a primer.",
        f"Have the cliché made from artwork.dxf. The pad carries dots {_MAPPINGS[spec.mapping]}; "
        "the artwork is drawn for that, as seen from the base of the dome. Its ellipses "
        f"become round dots of {layout.diameter:g} mm on the dome.",
        "Lay the skin into the cavity, opening up, its notch on the rib: it fits one way only. Print once on a film "
        f"that covers the cavity ({size}), with holes for its three pins. Shift the cavity "
        f"until opposite crosses ({across:.4g} mm and {along:.4g} mm apart) are equally far from the rim of the "
        "hollow to 0.1 mm, the one with the longer arm at the rib.",
        "Remove the film, and cover the crosses of the cliché with tape: they would print on the foot of the flange. "
        f"Print {len(layout)} dots{' and the orientation mark' if spec.orientation_mark else ''} in one stroke.",
        *(
            [
                "Without a pad printer: set template.stl into the dome, its notch towards that of the "
                "flange, and dab every hole."
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
        "measure nor adjust it: the calibration of the sensor finds the lens and its distance.",
        *([] if enclosure.frame else [seen]),
        "Pass the strip of LEDs from below through the hole at the edge of the shelf. Glue it to the wall of the "
        "housing directly under the flange, LEDs inward. Lead both cables through the slot.",
        *([window] if made.window else []),
        *([*barrel_assembly_steps(enclosure.frame), *check] if enclosure.frame else [flange, *check, ring]),
        torques(made.module),
        "Screw the robot plate to the robot (ISO 9409-1-50-4-M6, dowel glued into the plate): the housing covers "
        "these heads later. Then screw the housing to the plate from the robot's side, outside its flange of 63 mm: "
        "the four screws fit one way only, with the hole of the dowel under the cable slot. For a wrist that is "
        "wider than its flange, use a spacer between robot and plate, as thick as screws and key need.",
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


def write_sheet(path: Path, sections: Sequence[Section], drawings: Sequence[Figure], more: Sequence[Figure]) -> None:
    """Write the sheet as PDF on A4: text, tables, drawings, and further pages (the artwork 1:1)."""
    with PdfPages(path, metadata={"CreationDate": None}) as pages:
        lines = [line for section in sections if section.lines for line in _lay_out(section)]
        for start in range(0, len(lines), _LINES):
            pages.savefig(_page(lines[start : start + _LINES]))
        for section in sections:
            for page in _table_pages(section.title, section.table) if section.table else []:
                pages.savefig(page)
        for start in range(0, len(drawings), _ON_A_PAGE):
            pages.savefig(_page_of_drawings(drawings[start : start + _ON_A_PAGE]))
        for page in more:
            pages.savefig(page)


def _table_pages(title: str, table: Report) -> list[Figure]:
    """Draw the rows of a table, with the texts of its columns wrapped, on as many pages as they need."""
    rows = [[column.label for column in table.columns]]
    rows += [[column.text(row.get(column.name)) for column in table.columns] for row in table.rows]
    pages: list[Figure] = []
    used = float(_LINES)
    for k, row in enumerate(rows):
        cells = [textwrap.wrap(text, wide) for text, wide in zip(row, _CELLS, strict=True)]
        tall = max(len(cell) for cell in cells) + 0.4
        if used + tall > _LINES:
            pages.append(_page([(title, True)]))
            used = 2.0
        for cell, indent in zip(cells, np.cumsum([0, *_CELLS]), strict=False):
            x, y, weight = 0.06 + 0.0068 * indent, 0.955 - 0.0155 * used, "normal" if k else "bold"
            pages[-1].text(x, y, "\n".join(cell), fontsize=7, fontweight=weight, va="top", linespacing=1.35)
        used += 0.85 * tall
    return pages


def _page_of_drawings(drawings: Sequence[Figure]) -> Figure:
    """Arrange drawings below each other over the page's width, at the largest common scale."""
    page = Figure(figsize=_A4)
    shapes = [drawing.get_size_inches() for drawing in drawings]
    width = min(0.86 * _A4[0], 0.92 * _A4[1] / sum(height / wide for wide, height in shapes))
    bottom = 0.96 * _A4[1]
    for drawing, (wide, height) in zip(drawings, shapes, strict=True):
        tall = width * height / wide
        bottom -= tall
        drawing.set_dpi(_DRAWING_DPI)
        canvas = FigureCanvasAgg(drawing)
        canvas.draw()  # type: ignore[no-untyped-call]
        place = (0.5 * (1 - width / _A4[0]), bottom / _A4[1], width / _A4[0], tall / _A4[1])
        axis = page.add_axes(place)
        axis.imshow(canvas.buffer_rgba())  # type: ignore[no-untyped-call]
        axis.set_axis_off()
    return page


def _lay_out(section: Section) -> list[tuple[str, bool]]:
    """Return the lines of a section, and whether each is a heading."""
    lines = [(section.title, True)]
    for k, line in enumerate(section.lines, start=1):
        mark = f"{k}. " if section.steps else "·  "
        wrapped = textwrap.wrap(line, _WIDTH, initial_indent=mark, subsequent_indent="   ")
        lines += [(part, False) for part in wrapped]
    return [*lines, ("", False)]


def _page(lines: Sequence[tuple[str, bool]]) -> Figure:
    figure = Figure(figsize=_A4)
    for k, (line, heading) in enumerate(lines):
        size, weight = (11, "bold") if heading else (9, "normal")
        figure.text(0.09, 0.955 - k * 0.0155, line, fontsize=size, fontweight=weight, va="top")
    return figure
