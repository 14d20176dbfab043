"""Workshop drawings of the model: sections with dimensions, and views of bodies."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from palpate.core import FloatArray
from palpate.design import Arc, CadSolid, ContactModule, Outline, SmoothCurve, box, gather
from palpate.fabrication.enclosure import Enclosure
from palpate.fabrication.flange_key import NOTCH_AZIMUTH_DEG, notch_radius
from palpate.fabrication.window_plate import WindowPlate

_EYE = (300.0, -500.0, 400.0)
"""Viewpoint of bodies, mm."""
_FAR = 1e4
"""Half the edge of the box that is cut away, and distance of the viewpoint, mm."""
_ARC_POINTS = 60
_ABREAST = 6
"""Maximum number of bodies in a row."""
SILICONE, PLASTIC, CORE, GEL, GLASS = "#e8c9a8", "#8fa8c8", "#b8c9de", "#f6ecdf", "#dbe8ec"


def draw_module_section(module: ContactModule, window: WindowPlate | None = None) -> Figure:
    """Draw the section of a module with its dimensions; a filled one with gel and window."""
    figure, axis = blank_sheet((6.4, 4.6))
    skin, foot = module.skin, module.foot
    if window is not None:
        _fill(axis, follow_outline([(0.0, skin.height), *skin.meridian(0.0, down=True), (0.0, 0.0)]), GEL)
        low = -window.thickness
        _fill(axis, np.array([[0.0, 0.0], [window.reach, 0.0], [window.reach, low], [0.0, low]]), GLASS)
        axis.text(0, low / 2, f"window {window.thickness:g}", ha="center", va="center", fontsize=9)
    _fill(axis, follow_outline(module.outline()), SILICONE)
    top = skin.height + skin.thickness
    draw_dimension(
        axis, (-skin.base_radius, foot - 5), (skin.base_radius, foot - 5), f"2 B = {2 * skin.base_radius:.4g}"
    )
    draw_dimension(
        axis, (-module.flange_foot, foot - 10), (module.flange_foot, foot - 10), f"{2 * module.flange_foot:.4g}"
    )
    side = module.flange_foot + 5
    draw_dimension(axis, (side, 0.0), (side, skin.height), f"H = {skin.height:.4g}")
    draw_dimension(axis, (0.0, skin.height), (0.0, top), f"T = {skin.thickness:.4g}", offset=True)
    draw_dimension(axis, (-side, foot), (-side, 0.0), f"{module.flange_thickness:.4g}")
    axis.text(0, foot - 13, f"notch R {notch_radius(module):.3g} at {NOTCH_AZIMUTH_DEG:g}°", ha="center", fontsize=9)
    if skin.plan.is_round:
        axis.text(
            0, skin.height / 2, f"inner radius at the apex {skin.radius:.4g}", ha="center", va="center", fontsize=9
        )
    else:  # too low for a line of text
        said = f"along x; along y {skin.plan.stretch:.4g} times as long; inner radius of the edge {skin.radius:.4g}"
        axis.set_title(said, fontsize=9)
    axis.set_xlim(-side - 14, side + 14)
    axis.set_ylim(foot - 14, top + 5)
    return figure


def draw_mold_section(module: ContactModule, radius: float, floor: float, plate: float) -> Figure:
    """Draw the closed mold in section, in the position in which it is filled: apex down."""
    figure, axis = blank_sheet((6.4, 4.6))
    foot, top = module.foot, module.skin.height + module.skin.thickness + floor
    down = np.array([1.0, -1.0])
    _fill(axis, down * [[0, foot], [radius, foot], [radius, top], [0, top]], PLASTIC)
    _fill(axis, down * follow_outline(module.outside()), SILICONE)
    _fill(axis, down * follow_outline(module.inside()), CORE)
    _fill(axis, down * [[0, foot], [radius, foot], [radius, foot - plate], [0, foot - plate]], CORE)
    axis.text(0, -foot + plate / 2, "core", ha="center", va="center", fontsize=9)
    axis.text(0, -top + floor / 2, "cavity", ha="center", va="center", fontsize=9)
    side, inner = radius + 5, -module.skin.height
    draw_dimension(axis, (-radius, -top - 5), (radius, -top - 5), f"{2 * radius:.4g}")
    draw_dimension(axis, (side, -top), (side, -foot), f"{top - foot:.4g}")
    draw_dimension(axis, (side, -foot), (side, -foot + plate), f"{plate:.4g}")
    draw_dimension(axis, (-side, inner), (-side, -foot), f"{-foot - inner:.4g}")
    draw_dimension(axis, (-side, -top), (-side, -top + floor), f"{floor:.4g}")
    axis.set_xlim(-side - 9, side + 9)
    axis.set_ylim(-top - 8, -foot + plate + 4)
    return figure


def draw_enclosure_section(module: ContactModule, enclosure: Enclosure) -> Figure:
    """Draw the assembled enclosure, cut open along x, with its dimensions."""
    figure, axis = blank_sheet((6.4, 5.0))
    parts = enclosure.parts
    ring, housing, plate = (parts[name].bounds for name in ("clamp_ring", "housing", "robot_plate"))
    low, seat, high = float(plate[0, 2]), module.foot, module.skin.outer_height
    side = float(max(housing[1, 0], plate[1, 0]))
    lines = cut_open(list(parts.values()), 0.0)
    up = [
        0.0,
        float(ring[1, 2]) - max(float(line[:, 1].max()) for line in lines),
    ]  # a view is about the middle of its bodies
    _fill(axis, follow_outline(module.outline()), SILICONE)
    axis.add_collection(LineCollection([line + up for line in lines], colors="black", linewidths=0.7))
    for (left, right), z, at in ((ring[:, 0], seat, high + 4), (plate[:, 0], low, low - 6)):
        draw_dimension(axis, (left, at), (right, at), f"Ø {right - left:.4g}")
        axis.plot([left, left], [z, at], [right, right], [z, at], color="black", linewidth=0.3)
    draw_dimension(axis, (side + 5, low), (side + 5, high), f"{high - low:.4g}")
    draw_dimension(axis, (-side - 5, plate[1, 2]), (-side - 5, seat), f"{seat - plate[1, 2]:.4g}")
    draw_dimension(axis, (-side - 5, low), (-side - 5, plate[1, 2]), f"{plate[1, 2] - low:.4g}")
    draw_dimension(
        axis, (2.0, -enclosure.camera_distance), (2.0, 0.0), f"pinhole to base {enclosure.camera_distance:.4g}"
    )
    axis.set_xlim(-side - 16, side + 16)
    axis.set_ylim(low - 9, high + 8)
    return figure


def cut_open(parts: Sequence[CadSolid], azimuth: float) -> list[FloatArray]:
    """Return the visible lines (n, 2) mm of parts cut open through the axis at an azimuth (rad)."""
    away = box((-_FAR, -_FAR, -_FAR), (_FAR, 0.0, _FAR))
    halves = gather([part.turned("z", float(-np.degrees(azimuth))).cut(away) for part in parts])
    return halves.look((0.0, -_FAR, 0.0))


def draw_bodies(bodies: Sequence[tuple[str, CadSolid]]) -> Figure:
    """Draw the visible edges of bodies side by side, seen obliquely from above, to one scale."""
    rows = -(-len(bodies) // _ABREAST)
    columns = -(-len(bodies) // rows)
    figure = Figure(figsize=(3.4 * columns, 3.4 * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel()
    for axis in axes[len(bodies) :]:
        axis.set_axis_off()
    for axis, (name, body) in zip(axes, bodies, strict=False):
        middle = body.bounds.mean(axis=0)
        lines = body.moved(*(-middle)).look(_EYE)
        axis.add_collection(LineCollection(lines, colors="black", linewidths=0.7))
        axis.autoscale_view()
        axis.set_aspect("equal")
        axis.set_axis_off()
        axis.set_title(name.replace("_", " "), fontsize=10)
    return figure


def follow_outline(outline: Outline) -> FloatArray:
    """Return points (n, 2) mm along an outline, with its arcs in many short steps."""
    points: list[FloatArray] = [np.array([outline[0]], float)]
    for item in outline[1:]:
        if isinstance(item, Arc):
            points.append(_follow_arc(points[-1][-1], item))
        elif isinstance(item, SmoothCurve):
            points.append(np.array(item.through))
        else:
            points.append(np.array([item], float))
    return np.concatenate(points)


def _follow_arc(start: FloatArray, arc: Arc) -> FloatArray:
    a, b, c = start, np.array(arc.through), np.array(arc.end)
    matrix = 2 * np.array([b - a, c - a])
    center = np.linalg.solve(matrix, [b @ b - a @ a, c @ c - a @ a])
    first, middle, last = (np.arctan2(*(point - center)[::-1]) for point in (a, b, c))
    turn = (last - first) % (2 * np.pi)
    if (middle - first) % (2 * np.pi) > turn:
        turn -= 2 * np.pi
    angle = first + turn * np.linspace(0, 1, _ARC_POINTS + 1)[1:]
    radius = float(np.linalg.norm(a - center))
    return np.asarray(center + radius * np.column_stack([np.cos(angle), np.sin(angle)]))


def blank_sheet(size: tuple[float, float]) -> tuple[Figure, Axes]:
    """Create a figure of a size in inches, and its axes, to one scale and without frame."""
    figure = Figure(figsize=size, layout="constrained")
    axis = figure.add_subplot()
    axis.set_aspect("equal")
    axis.set_axis_off()
    return figure, axis


def _fill(axis: Axes, right: FloatArray, colour: str) -> None:
    """Fill a section, given by its right half (n, 2) mm."""
    whole = np.concatenate([right, right[::-1] * [-1.0, 1.0]])
    axis.add_patch(Polygon(whole, closed=True, facecolor=colour, edgecolor="none"))
    ends = np.roll(right, -1, axis=0)
    on_axis = (right[:, 0] == 0) & (ends[:, 0] == 0)
    lines = np.stack([right, ends], axis=1)[~on_axis]
    axis.add_collection(LineCollection([*lines, *(lines * [-1.0, 1.0])], colors="black", linewidths=1.0))


def draw_dimension(
    axis: Axes, start: tuple[float, float], end: tuple[float, float], text: str, *, offset: bool = False
) -> None:
    """Draw an arrow between two points with a text in mm."""
    axis.annotate("", end, start, arrowprops={"arrowstyle": "<->", "shrinkA": 0, "shrinkB": 0, "linewidth": 0.8})
    x, y = (np.array(start) + end) / 2
    upright = abs(start[0] - end[0]) < 1e-9
    if offset:
        axis.text(x, max(start[1], end[1]) + 0.6, text, ha="center", va="bottom", fontsize=9)
    elif upright:
        axis.text(x + np.copysign(1.0, x), y, text, ha="left" if x > 0 else "right", va="center", fontsize=9)
    else:
        axis.text(x, y + 0.6, text, ha="center", va="bottom", fontsize=9)
