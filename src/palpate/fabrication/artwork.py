"""Print pattern: the flat artwork of a cliché, from which a pad prints dots inside a dome.

The page shows the dome's inside as the pad approaches it from the base: x of the page is minus x of the dome, y is y,
because a viewer who looks along +z with y upward has -x to the right. A dot at the polar angle t of the inner sphere
is on the page

* ``axis``: at ``r sin t``, its distance from the axis; the pad moves along the axis and does not spread (the paper);
* ``arc``: at ``r t``; the pad rolls from the apex outward and preserves lengths along the meridian.

A dot that is round on the dome is an ellipse on the page.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray
from palpate.design import MarkerLayout, Skin, place_orientation_mark
from palpate.fabrication.spec import PadMapping

_MARGIN = 6.0
"""Distance of the alignment crosses from the rim, mm."""
_RIM_POINTS = 360
_HALVINGS = 60


@dataclass(frozen=True)
class Artwork:
    """Dots on a page whose origin is the dome's axis.

    Attributes
    ----------
    dots
        (n, 2) mm, in the order of the markers.
    axes
        (n, 2, 2) mm, the longer and the shorter semi-axis of each ellipse.
    diameter
        Diameter of a dot on the dome, mm.
    mark, mark_axes
        (2,) and (2, 2) mm, the orientation mark and its semi-axes, or `None`.
    crosses
        (4, 2) mm, centres of the alignment crosses, on the axes of the page.
    rim
        Distance of the dome's rim from the axis on the page, along x, mm.
    rim_line
        (n, 2) mm, the rim on the page; `None` for a circle.
    mapping
        Mapping of dots by the pad.
    """

    dots: FloatArray
    axes: FloatArray
    diameter: float
    mark: FloatArray | None
    mark_axes: FloatArray | None
    crosses: FloatArray
    rim: float
    mapping: PadMapping
    rim_line: FloatArray | None = None

    @property
    def ellipses(self) -> list[tuple[FloatArray, FloatArray]]:
        """Centres (2,) and semi-axes (2, 2) of the dots, and of the mark if there is one."""
        marks = [] if self.mark is None or self.mark_axes is None else [(self.mark, self.mark_axes)]
        return [*zip(self.dots, self.axes, strict=True), *marks]


def draw_artwork(skin: Skin, layout: MarkerLayout, mapping: PadMapping, *, mark: bool = True) -> Artwork:
    """Draw the markers of a skin, and with `mark` the orientation mark, on the page."""
    rim = float(
        np.abs(project_to_page(skin, skin.inner_point([min(skin.base_radius, skin.widest[0])], [0.0]), mapping)).max()
    )
    line = None if skin.plan.is_round else project_to_page(skin, _follow_rim(skin), mapping)
    across, along = (rim, rim) if line is None else np.abs(line).max(axis=0).tolist()
    x, y = across + _MARGIN, along + _MARGIN
    printed = layout.positions
    if mark:
        printed = np.vstack([printed, place_orientation_mark(skin, layout)])
    centres, axes = project_to_page(skin, printed, mapping), project_dots(skin, printed, layout.diameter, mapping)
    count = len(layout)
    return Artwork(
        dots=centres[:count],
        axes=axes[:count],
        diameter=layout.diameter,
        mark=centres[count] if mark else None,
        mark_axes=axes[count] if mark else None,
        crosses=np.array([[x, 0.0], [0.0, y], [-x, 0.0], [0.0, -y]]),
        rim=rim,
        mapping=mapping,
        rim_line=line,
    )


def mark_azimuth_deg(skin: Skin, layout: MarkerLayout) -> float:
    """Return the azimuth of the orientation mark."""
    x, y, _ = place_orientation_mark(skin, layout)
    return float(np.degrees(np.arctan2(y, x)))


def _follow_rim(skin: Skin) -> FloatArray:
    """Return points (n, 3) mm of the inner rim, once around."""
    angle = np.linspace(0.0, 2 * np.pi, _RIM_POINTS, endpoint=False)
    return skin.point(np.column_stack([np.cos(angle), np.sin(angle)]), 0.0)


def project_to_page(skin: Skin, points: FloatArray, mapping: PadMapping) -> FloatArray:
    """Map points (n, 3) mm of the inner surface to the page (n, 2) mm."""
    rho = np.hypot(points[:, 0], points[:, 1])
    if mapping is PadMapping.ARC:
        length = skin.arc_length(points)
        scale = np.divide(length, rho, out=np.ones_like(rho), where=rho > 0)
    else:
        scale = np.ones_like(rho)
    return np.asarray(points[:, :2] * scale[:, None] * [-1.0, 1.0])


def project_dots(skin: Skin, points: FloatArray, diameter: float, mapping: PadMapping) -> FloatArray:
    """Return the semi-axes (n, 2, 2) mm on the page, longer first, of dots that are round on the dome."""
    _, along, around = skin.tangents(points)
    ends = [
        project_to_page(skin, skin.nearest(points + side * diameter / 2 * tangent), mapping)
        for tangent in (along, around)
        for side in (1, -1)
    ]
    conjugate = np.stack([(ends[0] - ends[1]) / 2, (ends[2] - ends[3]) / 2], axis=2)
    turn, length, _ = np.linalg.svd(conjugate)
    return np.asarray(np.swapaxes(turn * length[:, None, :], 1, 2))


def project_to_skin(skin: Skin, page: FloatArray, mapping: PadMapping) -> FloatArray:
    """Map points (n, 2) mm of the page to the inner surface (n, 3) mm, like the pad."""
    reach, azimuth = np.hypot(page[:, 0], page[:, 1]), np.arctan2(page[:, 1], -page[:, 0])
    if mapping is PadMapping.ARC:
        reach = skin.at_arc_length(reach) if skin.plan.is_round else _arc_to_axis(skin, reach, azimuth)
    return skin.inner_point(reach, azimuth)


def _arc_to_axis(skin: Skin, length: FloatArray, azimuth: FloatArray) -> FloatArray:
    """Return distances (n,) mm from the axis at azimuths (rad) and arc lengths (mm) from the apex."""
    low, high = np.zeros_like(length), skin.reach(azimuth)
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        short = skin.arc_length(skin.inner_point(middle, azimuth)) < length
        low, high = np.where(short, middle, low), np.where(short, high, middle)
    return np.asarray(low)
