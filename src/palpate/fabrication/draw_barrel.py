"""Workshop drawings of a barrel, with the rim to the left: sections, and a cut assembly."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from palpate.core import FloatArray
from palpate.design import CadSolid, ContactModule
from palpate.fabrication.draw import CORE, PLASTIC, SILICONE, blank_sheet, cut_open, draw_dimension, follow_outline
from palpate.fabrication.mold import Mold

_SIZE = (7.4, 3.7)


def draw_barrel_section(module: ContactModule) -> Figure:
    """Draw the section of a barrel's module with its dimensions."""
    figure, axis = blank_sheet(_SIZE)
    skin, side = module.skin, module.skin.outer_widest[0]
    _fill(axis, follow_outline(module.outline()), SILICONE)
    draw_dimension(axis, (0.0, -side - 8), (skin.height, -side - 8), f"H = {skin.height:.4g}")
    draw_dimension(axis, (0.0, -skin.base_radius), (0.0, skin.base_radius), f"2 B = {2 * skin.base_radius:.4g}")
    middle, wide = skin.height / 2, skin.widest[0]
    draw_dimension(axis, (middle, -wide), (middle, wide), f"{2 * wide:.4g}")
    draw_dimension(axis, (middle, wide), (middle, side), "")
    axis.text(middle, side + 2, f"T = {skin.thickness:.4g}", ha="center", va="bottom", fontsize=9)
    low, high = module.foot - 22, module.top + 8
    draw_dimension(axis, (low, -module.flange_foot), (low, module.flange_foot), f"{2 * module.flange_foot:.4g}")
    draw_dimension(
        axis, (skin.height, side + 4), (module.top, side + 4), f"{module.flange_thickness:.4g}", offset=True
    )
    axis.set_xlim(low - 14, high + 10)
    axis.set_ylim(-side - 12, side + 10)
    return figure


def draw_barrel_mold(mold: Mold, floor: float, plate: float, spigot: float) -> Figure:
    """Draw the closed mold in section; it is filled upright, the left end up."""
    figure, axis = blank_sheet(_SIZE)
    module, radius = mold.module, mold.radius
    foot, top = module.foot, module.top
    _fill(axis, np.array([[0, foot], [radius, foot], [radius, top + floor], [0, top + floor]]), PLASTIC)
    _fill(axis, follow_outline(module.outside()), SILICONE)
    _fill(axis, follow_outline(module.inside()), CORE)
    _fill(axis, np.array([[0, top], [spigot, top], [spigot, top + floor], [0, top + floor]]), CORE)
    _fill(axis, np.array([[0, foot - plate], [radius, foot - plate], [radius, foot], [0, foot]]), CORE)
    axis.text(module.skin.height / 2, 0.0, "core", ha="center", va="center", fontsize=9)
    axis.text(module.skin.height / 2, radius + 3, "cavity, in halves", ha="center", va="bottom", fontsize=9)
    axis.set_xlim(foot - plate - 4, top + floor + 4)
    axis.set_ylim(-radius - 4, radius + 12)
    return figure


def draw_cut_open(parts: Sequence[CadSolid], azimuth: float) -> Figure:
    """Draw parts, cut open along the plane through the axis at an azimuth (rad)."""
    figure, axis = blank_sheet((_SIZE[0], 2.9))
    lines = [line[:, ::-1] for line in cut_open(parts, azimuth)]
    axis.add_collection(LineCollection(lines, colors="black", linewidths=0.7))
    axis.autoscale_view()
    return figure


def _fill(axis: Axes, half: FloatArray, colour: str) -> None:
    """Fill a section, given by one half (n, 2) mm: distance from the axis, and position along it."""
    places = [half[:, ::-1], half[:, ::-1] * [1.0, -1.0]]
    if half[:, 0].min() <= 0:
        places = [np.concatenate([places[0], places[1][::-1]])]
    for place in places:
        axis.add_patch(Polygon(place, closed=True, facecolor=colour, edgecolor="black", linewidth=1.0))
