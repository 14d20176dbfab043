"""Artwork files for the workshop: DXF for the cliché, SVG and PDF at 1:1; and lines to cut along."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from palpate.core import FloatArray, load_extra
from palpate.fabrication.artwork import Artwork
from palpate.fabrication.drawing_sheet import LETTERS, MM_PER_INCH, PAGE, TitleBlock

CROSS, LINE = 4.0, 0.1
"""Length of the arms of a cross and width of lines, mm."""
BAR = 50.0
"""Length of the bar for checking the scale of a print, mm."""


def write_dxf(path: Path, artwork: Artwork) -> None:
    """Write DXF R2010 in mm: dots as ellipses on the layer DOTS, and MARK, ALIGNMENT, RIM."""
    ezdxf = load_extra("ezdxf", "cad")
    document = ezdxf.new("R2010", units=ezdxf.units.MM)
    for name, colour in (("DOTS", 7), ("MARK", 1), ("ALIGNMENT", 5), ("RIM", 8)):
        document.layers.add(name, color=colour)
    space = document.modelspace()
    for number, (centre, (longer, shorter)) in enumerate(artwork.ellipses):
        layer = "DOTS" if number < len(artwork.dots) else "MARK"
        ratio = float(np.linalg.norm(shorter) / np.linalg.norm(longer))
        space.add_ellipse((*centre, 0.0), (*longer, 0.0), ratio, dxfattribs={"layer": layer})
    for start, end in _strokes(artwork):
        space.add_line(start, end, dxfattribs={"layer": "ALIGNMENT"})
    if artwork.rim_line is None:
        space.add_circle((0.0, 0.0), artwork.rim, dxfattribs={"layer": "RIM"})
    else:
        space.add_lwpolyline(artwork.rim_line.tolist(), close=True, dxfattribs={"layer": "RIM"})
    document.saveas(path)


def write_cut(path: Path, line: FloatArray) -> None:
    """Write a closed line (n, 2) mm to cut a sheet along as DXF R2010 in mm, on the layer CUT."""
    ezdxf = load_extra("ezdxf", "cad")
    document = ezdxf.new("R2010", units=ezdxf.units.MM)
    document.layers.add("CUT", color=1)
    document.modelspace().add_lwpolyline(line.tolist(), close=True, dxfattribs={"layer": "CUT"})
    document.saveas(path)


def write_svg(path: Path, artwork: Artwork) -> None:
    """Write SVG whose user unit is 1 mm, y of the page upward."""
    reach = float(artwork.crosses.max()) + CROSS
    size = 2 * reach
    ellipses = [_svg_ellipse(*one) for one in artwork.ellipses]
    count = len(artwork.dots)
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{size:.3f}mm" height="{size:.3f}mm" '
        f'viewBox="{-reach:.3f} {-reach:.3f} {size:.3f} {size:.3f}">',
        f"<title>{len(artwork.dots)} dots, {artwork.diameter:g} mm on the dome, mapping: {artwork.mapping}</title>",
        '<g id="dots" fill="black">',
        *ellipses[:count],
        "</g>",
        *(f'<g id="mark" fill="black">{mark}</g>' for mark in ellipses[count:]),
    ]
    lines.append(f'<g id="alignment" stroke="black" stroke-width="{LINE}">')
    lines += [
        f'<line x1="{a:.4f}" y1="{-b:.4f}" x2="{c:.4f}" y2="{-d:.4f}"/>' for (a, b), (c, d) in _strokes(artwork)
    ]
    lines += ["</g>", "</svg>", ""]
    path.write_text("\n".join(lines), encoding="utf-8")


def write_pdf(path: Path, artwork: Artwork, block: TitleBlock) -> None:
    """Write an A4 page at 1:1 with a bar for checking the scale of the print."""
    figure = draw_page(artwork, block)
    figure.savefig(path, format="pdf", metadata={"CreationDate": None})


def draw_page(artwork: Artwork, block: TitleBlock) -> Figure:
    """Draw the page at 1:1."""
    figure = Figure(figsize=(PAGE[0] / MM_PER_INCH, PAGE[1] / MM_PER_INCH))
    axis = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axis.set_xlim(-PAGE[0] / 2, PAGE[0] / 2)
    axis.set_ylim(-PAGE[1] / 2, PAGE[1] / 2)
    axis.set_axis_off()
    for centre, axes in artwork.ellipses:
        size = 2 * np.linalg.norm(axes, axis=1)
        axis.add_patch(Ellipse(tuple(centre), *size, angle=_angle_deg(axes), color="black", linewidth=0))
    for (a, b), (c, d) in _strokes(artwork):
        axis.plot([a, c], [b, d], color="black", linewidth=0.4)
    low = -PAGE[1] / 2 + 55.0
    axis.plot([-BAR / 2, BAR / 2], [low, low], color="black", linewidth=0.8)
    for end in (-BAR / 2, BAR / 2):
        axis.plot([end, end], [low - 2, low + 2], color="black", linewidth=0.8)
    axis.text(0, low - 8, f"This bar is {BAR:g} mm long. Print without scaling.", ha="center", fontsize=LETTERS)
    words = [
        "As seen when the pad approaches the dome, from its base.",
        "Mirrored: angle here = 180° − angle of the part.",
    ]
    if artwork.mark is not None:
        turn = float(np.degrees(np.arctan2(artwork.mark[1], artwork.mark[0])))
        words.append(f"Orientation mark: {turn:.4g}° here, {180 - turn:.4g}° on the part.")
    axis.text(0, PAGE[1] / 2 - 12, "\n".join(words), ha="center", va="top", fontsize=LETTERS, linespacing=1.5)
    figure.set_label("1 : 1")
    block.draw(figure, "artwork")
    return figure


def _svg_ellipse(centre: FloatArray, axes: FloatArray) -> str:
    x, y = centre[0], -centre[1]
    longer, shorter = np.linalg.norm(axes, axis=1)
    turn = f"rotate({-_angle_deg(axes):.4f} {x:.4f} {y:.4f})"
    return f'<ellipse cx="{x:.4f}" cy="{y:.4f}" rx="{longer:.4f}" ry="{shorter:.4f}" transform="{turn}"/>'


def _angle_deg(axes: FloatArray) -> float:
    """Return the angle of the longer semi-axis, from x to y."""
    return float(np.degrees(np.arctan2(axes[0, 1], axes[0, 0])))


def _strokes(artwork: Artwork) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """Return the lines of the alignment crosses; that on the side of the flange's notch has a longer arm."""
    arm, (low, below) = CROSS / 2, artwork.crosses[3].tolist()
    crosses = [
        ((x - dx, y - dy), (x + dx, y + dy))
        for x, y in artwork.crosses.tolist()
        for dx, dy in ((arm, 0.0), (0.0, arm))
    ]
    return [*crosses, ((low, below), (low, below - CROSS))]
