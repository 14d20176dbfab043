"""Elements of drawings: A4 page to scale with title block, sections, views, dimensions and names.

A page is drawn at the largest scale of ISO 5455 that fits. Letters are 2.5 mm high or more (ISO 3098). Azimuths are
those of the part: counter-clockwise from x, seen from the apex.
"""

from __future__ import annotations

import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from palpate.core import FloatArray, provenance
from palpate.design import CadSolid, ContactModule, box

Point = tuple[float, float]
Place = Sequence[float] | FloatArray
"""Position (x, y), mm."""
PAGE = (210.0, 297.0)
"""A4, mm."""
MM_PER_INCH = 25.4
LETTERS = 10.0
"""Size of letters, points: capitals of 2.6 mm."""
_ROOM = ((15.0, 46.0), (195.0, 292.0))
"""Lower left and upper right corner of the drawing on its page, mm."""
_NAMES, _DIMENSIONS, _BELOW, _ABOVE = 36.0, 30.0, 16.0, 10.0
"""Space on the left for names, on the right for dimensions, below and above, mm of the page."""
_SCALES = (5.0, 2.0, 1.0, 0.5, 0.2, 0.1)
"""Scales of ISO 5455, for designs of up to 1.5 m."""
_LEVELS, _COLUMNS = (12.0, 20.0, 28.0, 36.0), (17.0, 105.0, 160.0)
"""Levels of the lines of a title block, and left ends of its columns, mm of the page."""
_EYE = (300.0, -500.0, 400.0)
"""Viewpoint of bodies, mm."""
_FAR = 1e4
"""Half the edge of the box that is cut away, and distance of the viewpoint, mm."""
_SLICE = 0.5
"""Thickness of the slice behind a section, whose face is drawn, mm."""
_ON_PLANE = 1e-6
"""Distance from the plane of a section at which a point is on it, mm."""
_LINE_MM, _LABEL, _PLAN_GAP = 6.0, (2.0, 3.5, 0.05), 34.0
"""Distance of lines, letters (width, height, step aside in rad), and space around a plan, mm."""


@dataclass(frozen=True)
class Sheet:
    """Page of a drawing; `unit` is the length in mm that is 1 mm on the page."""

    figure: Figure
    axis: Axes
    unit: float

    @classmethod
    def around(cls, low: Sequence[float], high: Sequence[float], gap: float = 0.0) -> Sheet:
        """Make a page for content from `low` to `high` (x, y) mm, and `gap` mm of the page in it.

        The scale becomes the label of the figure.
        """
        size, room = np.subtract(high, low), np.subtract(_ROOM[1], _ROOM[0])
        free = room - [_NAMES + _DIMENSIONS, _BELOW + _ABOVE + gap]
        scale = next((scale for scale in _SCALES if (scale * size <= free).all()), _SCALES[-1])
        middle = np.add(high, low) / 2 + np.array([_DIMENSIONS - _NAMES, _ABOVE - _BELOW - gap]) / 2 / scale
        figure = Figure(figsize=(PAGE[0] / MM_PER_INCH, PAGE[1] / MM_PER_INCH))
        figure.set_label(f"{scale:g} : 1" if scale >= 1 else f"1 : {1 / scale:g}")
        axis = figure.add_axes((*np.divide(_ROOM[0], PAGE), *np.divide(room, PAGE)))
        axis.set_xlim(*(middle[0] + np.array([-0.5, 0.5]) * room[0] / scale))
        axis.set_ylim(*(middle[1] + np.array([-0.5, 0.5]) * room[1] / scale))
        axis.set_axis_off()
        return cls(figure, axis, 1 / scale)

    def write(self, place: Place, text: str, across: str = "center", up: str = "center") -> None:
        """Write a text at (x, y) mm."""
        self.axis.text(float(place[0]), float(place[1]), text, ha=across, va=up, fontsize=LETTERS)

    def line(self, *points: Place, width: float = 0.4, style: str = "-") -> None:
        """Draw a thin line through points (x, y) mm."""
        self.axis.plot(*np.array(points).T, color="black", linewidth=width, linestyle=style)

    def lines(self, lines: Sequence[FloatArray]) -> None:
        """Draw visible edges, polylines (n, 2) mm."""
        self.axis.add_collection(LineCollection(lines, colors="black", linewidths=0.7))

    def dimension(self, start: Point, end: Point, text: str, edge: float | None = None) -> None:
        """Draw an arrow between two points with a text in mm, on the right of it or above it.

        Lines extend from it to the part, whose x (of an upright arrow) or y is `edge` mm.
        """
        style = {"arrowstyle": "<->", "shrinkA": 0, "shrinkB": 0, "linewidth": 0.8}
        self.axis.annotate("", end, start, arrowprops=style)
        x, y = np.add(start, end) / 2
        if abs(start[0] - end[0]) < 1e-9:
            self.write((x + 1.5 * self.unit, y), text, "left")
        else:
            self.write((x, y + 0.8 * self.unit), text, up="bottom")
        if edge is not None:
            for tip in (start, end):
                self.line((edge, tip[1]) if start[0] == end[0] else (tip[0], edge), tip, width=0.3)

    def names(self, anchors: Mapping[str, FloatArray], edge: float) -> None:
        """Write names left of x = `edge` mm, below each other, with lines to their anchors (x, y) mm."""
        level = np.inf
        for name, anchor in sorted(anchors.items(), key=lambda item: -item[1][1]):
            level = min(level - _LINE_MM * self.unit, float(anchor[1]))
            self.write((edge, level), name, "right")
            self.line((edge + self.unit, level), anchor)
            self.axis.plot(*anchor, "k.", markersize=3)


def cut_part(part: CadSolid, azimuth_deg: float, thickness: float) -> tuple[FloatArray, FloatArray, CadSolid] | None:
    """Cut a part by the half-plane at an azimuth; `None` if they do not meet.

    Returns
    -------
    tuple
        Triangles (n, 3, 2) mm of the section, distance from the axis and z; its edges (m, 2, 2) mm; and the slice of
        the part behind it, `thickness` mm.
    """
    away = [box((-_FAR, -_FAR, -_FAR), high) for high in ((_FAR, 0.0, _FAR), (0.0, _FAR, _FAR))]
    away.append(box((-_FAR, thickness, -_FAR), (_FAR, 2 * _FAR, _FAR)))
    piece = part.turned("z", -azimuth_deg).cut(*away)
    if not piece.pieces:
        return None
    mesh = piece.mesh()
    on = np.abs(mesh.points[:, 1]) < _ON_PLANE
    faces = mesh.triangles[on[mesh.triangles].all(axis=1)]
    places = mesh.points[:, [0, 2]]
    sides = np.sort(np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)]), axis=1)
    sides, count = np.unique(sides, axis=0, return_counts=True)
    edges = places[sides[count == 1]]
    outside = np.abs(edges[..., 0]).max(axis=1) > _ON_PLANE
    return (places[faces], edges[outside], piece) if len(faces) else None


def _view(part: CadSolid) -> list[FloatArray]:
    """Return the visible edges of a part seen along y, polylines (n, 2) mm of x and z."""
    lines = part.look((0.0, -_FAR, 0.0))  # about the middle of the body
    return [line + part.bounds[1, [0, 2]] - np.concatenate(lines).max(axis=0) for line in lines]


def draw_cut(
    sheet: Sheet,
    parts: Mapping[str, tuple[CadSolid, str]],
    azimuths_deg: tuple[float, float],
    to_page: tuple[float, float] = (1.0, 0.0),
    *,
    behind: bool = False,
) -> dict[str, FloatArray]:
    """Draw parts (solid and colour by name) cut at two azimuths, right and left of the axis.

    `to_page` is the factor of z on the page, and its addend, mm. Edges behind the section are drawn with
    `behind`. Returns a place (x, y) mm on each part.
    """
    anchors: dict[str, FloatArray] = {}
    for side, azimuth in zip((1.0, -1.0), azimuths_deg, strict=True):
        for name, (part, colour) in parts.items():
            if (found := cut_part(part, azimuth, _FAR if behind else _SLICE)) is None:
                continue
            factor, addend = np.array([side, to_page[0]]), np.array([0.0, to_page[1]])
            triangles, edges = (places * factor + addend for places in found[:2])
            if behind:
                lines = [line * factor + addend for line in _view(found[2])]
                sheet.axis.add_collection(LineCollection(lines, colors="gray", linewidths=0.4, zorder=0))
            sheet.axis.add_collection(PolyCollection(triangles, facecolors=colour, edgecolors=colour, linewidths=0.8))
            sheet.axis.add_collection(LineCollection(edges, colors="black", linewidths=0.8))
            (ax, ay), (bx, by) = (triangles[:, 1] - triangles[:, 0]).T, (triangles[:, 2] - triangles[:, 0]).T
            anchors[name] = triangles[np.abs(ax * by - ay * bx).argmax()].mean(axis=0)
    return anchors


def draw_bodies(bodies: Sequence[tuple[str, CadSolid]]) -> Figure:
    """Draw bodies below each other on one axis, seen obliquely from above, with their names."""
    views = []
    for name, body in bodies:
        lines = body.moved(*(-body.bounds.mean(axis=0))).look(_EYE)
        points = np.concatenate(lines)
        low, high = points.min(axis=0), points.max(axis=0)
        views.append((name, [line - (low + high) / 2 for line in lines], (high - low) / 2))
    wide, gap = max(half[0] for *_, half in views), 0.1 * max(half[1] for *_, half in views)
    tall = 2 * sum(half[1] + gap for *_, half in views)
    sheet = Sheet.around((-wide, -tall), (wide, 0.0))
    top, anchors = 0.0, {}
    sheet.line((0.0, 0.0), (0.0, -tall), width=0.3, style="-.")
    for name, lines, half in views:
        middle = np.array([0.0, top - half[1]])
        sheet.lines([line + middle for line in lines])
        left = min(lines, key=lambda line: line[:, 0].min())
        anchors[name] = left[left[:, 0].argmin()] + middle
        top -= 2 * (half[1] + gap)
    sheet.names(anchors, -wide - 5 * sheet.unit)
    return sheet.figure


@dataclass(frozen=True)
class Plan:
    """View of a part along its axis with features by azimuth, deg: an angle of the plan of `mold`.

    `sizes` gives diameters of features and of their circles.
    """

    title: str
    sizes: str
    part: CadSolid
    features: tuple[tuple[float, str], ...]
    mold: ContactModule | None = None

    def way(self, azimuth_deg: float) -> FloatArray:
        """Return the direction (2,) of an azimuth on the page; x of a mold, seen from the base, is left."""
        if self.mold is None:
            return np.array([np.cos(np.radians(azimuth_deg)), np.sin(np.radians(azimuth_deg))])
        place = np.array(self.mold.place(1.0, azimuth_deg)) * [-1.0, 1.0]
        return np.asarray(place / np.linalg.norm(place))


def draw_plans(plans: Sequence[Plan]) -> Figure:
    """Draw views along the axis below each other, each feature with its azimuth."""
    views = [
        _view(plan.part.turned("x", 90.0) if plan.mold is None else plan.part.turned("z", 180.0).turned("x", -90.0))
        for plan in plans
    ]
    reach = max(float(np.linalg.norm(line, axis=1).max()) for view in views for line in view)
    sheet = Sheet.around((-reach, -2.0 * reach * len(plans)), (reach, 0.0), _PLAN_GAP * len(plans) - _BELOW - _ABOVE)
    for k, (plan, view) in enumerate(zip(plans, views, strict=True)):
        centre = np.array([0.0, -(2 * k + 1) * reach - (k + 0.5) * _PLAN_GAP * sheet.unit])
        sheet.lines([line + centre for line in view])
        seen = "from the base, mirrored: 180° − angle" if plan.mold else "from the apex: angles as shown"
        head = centre + np.array([0.0, reach + (_PLAN_GAP / 2 - _LINE_MM) * sheet.unit])
        sheet.write(head, f"{plan.sizes}\n{plan.title}. Seen {seen}", up="bottom")
        _name_features(sheet, centre, reach, plan)
    return sheet.figure


def _name_features(sheet: Sheet, centre: FloatArray, reach: float, plan: Plan) -> None:
    """Write features around a view, clear of other names and their lines."""
    names, lines, far = np.empty((0, 2)), np.empty((0, 2)), reach / sheet.unit + 4.0
    for azimuth in sorted({azimuth for azimuth, _ in plan.features}):
        text = f"{', '.join(name for at, name in plan.features if at == azimuth)} {azimuth:.4g}°"
        way, turn = plan.way(azimuth), 0.0
        while True:
            aside = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ way
            across = "center" if abs(aside[0]) < 0.1 else "left" if aside[0] > 0 else "right"
            spread = np.linspace(0, _LABEL[0] * len(text), len(text)) * (1.0 if across == "left" else -1.0)
            spread -= spread.mean() if across == "center" else 0.0
            name = far * aside + np.column_stack([spread, np.zeros(len(text))])
            bends = (far - _LABEL[1]) * way, (far - 2.5) * aside
            line = np.linspace(*bends, len(text))
            if turn > np.pi or not (_meet(name, np.concatenate([names, lines])) or _meet(line, names)):
                break
            turn = -turn if turn > 0 else _LABEL[2] - turn
        names, lines = np.concatenate([names, name]), np.concatenate([lines, line])
        sheet.line(centre, *(centre + sheet.unit * bend for bend in bends), width=0.3, style="-.")
        sheet.write(centre + far * sheet.unit * aside, text, across)


def _meet(points: FloatArray, others: FloatArray) -> bool:
    """Whether points (n, 2) and others (m, 2), mm of the page, are closer than letters are high."""
    return bool((np.abs(points[:, None] - others).max(axis=-1, initial=0.0) < _LABEL[1]).any())


@dataclass(frozen=True)
class TitleBlock:
    """Lines of a title block: design with its material, and origin of the pack."""

    design: str
    material: str

    @property
    def origin(self) -> str:
        """Version of palpate and date; `SOURCE_DATE_EPOCH` sets the date of a reproducible pack."""
        now = time.gmtime(int(os.environ.get("SOURCE_DATE_EPOCH") or time.time()))
        return f"palpate {provenance()['palpate']}, {time.strftime('%Y-%m-%d', now)}"

    def draw(self, figure: Figure, name: str) -> None:
        """Draw the block at the foot of a drawing, whose label is its scale."""
        rows = (
            ("mm; ISO 2768-m where the sheet gives no tolerance", "", ""),
            (self.material, self.origin, ""),
            (self.design, name, f"scale {figure.get_label()}"),
        )
        for low, row in zip(_LEVELS, rows, strict=False):
            for x, text in zip(_COLUMNS, row, strict=True):
                _write(figure, x, low, text)
        for level in _LEVELS:
            _rule(figure, level)

    def number(self, figure: Figure, page: int, pages: int) -> None:
        """Write the number of a page at its lower right."""
        _write(figure, _COLUMNS[-1], _LEVELS[0], f"page {page} of {pages}")

    def head(self, figure: Figure) -> None:
        """Write design, material and origin at the foot of a page of text."""
        _rule(figure, _LEVELS[1])
        _write(figure, _COLUMNS[0], _LEVELS[0], f"{self.design}. {self.origin}")


def _write(figure: Figure, x: float, y: float, text: str) -> None:
    figure.text(x / PAGE[0], (y + 2.5) / PAGE[1], text, fontsize=LETTERS)


def _rule(figure: Figure, level: float) -> None:
    ends = [_ROOM[0][0] / PAGE[0], _ROOM[1][0] / PAGE[0]], [level / PAGE[1]] * 2
    figure.add_artist(Line2D(*ends, color="black", linewidth=0.6))
