"""Limits of a design in manufacture, each a finding with its values."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from palpate.camera import Camera
from palpate.core import FloatArray
from palpate.design import (
    Design,
    Finding,
    MarkerLayout,
    Severity,
    Skin,
    check_design,
    place_orientation_mark,
)
from palpate.fabrication.artwork import project_dots, project_to_page
from palpate.fabrication.spec import ProcessSpec
from palpate.material import Material

_SAGITTA = 0.03
"""Maximum height of a dot's cap over its diameter; beyond, the pad smears its edge."""
_SMALLEST_PX = 5.0
"""Minimum diameter of a dot's image for an accurate centre."""
_SLENDER = 5.0
"""Maximum length of a pin over its diameter, so that it comes out of the core whole; our choice."""
_PEEL = 0.5
"""Maximum share of the material's stretch range for peeling."""
_UNEVEN, _TOUCHES = 0.1, 0.5
"""Clearance of the core over the skin thickness at which the skin is uneven, and the core may touch."""
_DEEPER = 1.5
"""Minimum depth of a dimple over the curvature height of the core at its edge."""
_PEEL_UNKNOWN = 2.0
"""Stretch that every soft silicone bears, for materials without a range."""


def check_process(design: Design, spec: ProcessSpec) -> tuple[Finding, ...]:
    """Report the limits of demolding, dots, pad and camera that a design exceeds, errors first."""
    skin, layout = design.skin, design.layout
    findings = [
        *check_design(skin, layout),
        *_check_wall(skin),
        *_check_peeling(skin, design.material),
        *_check_dots(skin, layout, design.camera, spec),
        *(_check_dimples(skin, layout, spec) if skin.hole else ()),
        *(_check_pins(skin, layout) if skin.pin else ()),
        *(() if skin.hole or skin.pin else _check_pad(skin, layout, spec)),
    ]
    order = list(Severity)
    return tuple(sorted(findings, key=lambda finding: order.index(finding.severity)))


def _check_wall(skin: Skin) -> Iterator[Finding]:
    if skin.thickness >= skin.radius:
        yield Finding(
            Severity.ERROR,
            "not-a-shell",
            f"A skin of {skin.thickness:g} mm on an inner radius of {skin.radius:.4g} mm is too thick for a mold.",
            f"Use a thickness below {skin.radius:.4g} mm.",
        )


def _check_peeling(skin: Skin, material: Material) -> Iterator[Finding]:
    if not skin.bulges:
        return
    stretch, depth = skin.widest[0] / skin.base_radius, skin.widest[0] - skin.base_radius
    known = np.isfinite(material.stretch_range[1])
    limit = 1 + _PEEL * (material.stretch_range[1] - 1) if known else _PEEL_UNKNOWN
    where = f"the part must stretch {stretch:.3g} times to be peeled off the core (undercut {depth:.3g} mm)"
    what = "The barrel bulges" if skin.hole else "The dome bulges over its base"
    if stretch > limit:
        smaller = (
            f"Use a radius halfway below {skin.base_radius * limit:.3g} mm or wider ends."
            if skin.hole
            else f"Use a height below {skin.height * limit / stretch:.3g} mm or a wider base."
        )
        yield Finding(Severity.ERROR, "peel-stretch", f"{what}, so {where}; it bears {limit:.3g} safely.", smaller)
    else:
        off = "push it off over the far end" if skin.hole else "peel from the flange"
        yield Finding(
            Severity.WARNING,
            "peel-stretch",
            f"{what}, so {where}; it bears {limit:.3g} safely." if skin.hole else f"{what}, so {where}.",
            f"The cavity is made in halves; wet the core with soapy water and {off}.",
        )


def _sagitta(skin: Skin, layout: MarkerLayout) -> float:
    """Return the maximum distance in mm of the inner surface from the tangent plane under a dot."""
    points = layout.positions[layout.on_dome]
    _, along, around = skin.tangents(points)
    return float(np.abs([skin.distance(points + layout.diameter / 2 * way) for way in (along, around)]).max())


def _check_dots(skin: Skin, layout: MarkerLayout, camera: Camera, spec: ProcessSpec) -> Iterator[Finding]:
    diameter = layout.diameter
    if diameter < spec.min_marker_diameter:
        yield Finding(
            Severity.ERROR,
            "dot-too-small",
            f"Dots are {diameter:g} mm wide; {'ink fills dimples' if skin.hole else 'the pad prints'} from "
            f"{spec.min_marker_diameter:g} mm.",
            f"Use dots of at least {spec.min_marker_diameter:g} mm.",
        )
    points = layout.positions[layout.on_dome]
    sagitta = _sagitta(skin, layout)
    if sagitta > _SAGITTA * diameter and not (skin.pin or skin.hole):
        yield Finding(
            Severity.WARNING,
            "dot-on-curve",
            f"A dot of {diameter:g} mm is a cap {sagitta:.2g} mm high on an inner radius of {skin.radius:.3g} mm.",
            f"Use dots below {8 * skin.radius * _SAGITTA:.2g} mm, or a flatter dome.",
        )
    beside = points + np.array([diameter, 0.0, 0.0])
    size = np.linalg.norm(camera.project(beside) - camera.project(points), axis=1)
    if size.min() < _SMALLEST_PX:
        yield Finding(
            Severity.WARNING,
            "dot-in-pixels",
            f"The smallest dot is {size.min():.2g} pixels wide in the camera.",
            f"Use dots of at least {diameter * _SMALLEST_PX / size.min():.2g} mm, or a nearer or sharper camera.",
        )
    unseen = ~camera.visible(points, skin)
    if unseen.any():
        yield Finding(
            Severity.WARNING,
            "marker-unseen",
            f"The camera does not see {int(unseen.sum())} of {len(points)} markers.",
            "Move the camera back, or use a wider lens.",
        )


def _reached(skin: Skin, steepest_deg: float) -> float:
    """Return the distance in mm from the axis up to which the inner surface's slope is within a limit."""
    s = np.linspace(0.0, 1.0, 2001)
    points = skin.point(np.column_stack([s, 0.0 * s]), 0.0)
    level = skin.normal(points)[:, 2] >= np.cos(np.radians(steepest_deg))
    return float(points[level, 0].max())


def _check_pins(skin: Skin, layout: MarkerLayout) -> Iterator[Finding]:
    """Report the limits of pins that are cast with the skin."""
    if skin.pin > _SLENDER * layout.diameter:
        yield Finding(
            Severity.WARNING,
            "pins-slender",
            f"A pin {skin.pin:g} mm long is {layout.diameter:g} mm wide: it may tear in the core.",
            f"Use pins of at most {_SLENDER * layout.diameter:.3g} mm, or wider ones.",
        )


def _check_dimples(skin: Skin, layout: MarkerLayout, spec: ProcessSpec) -> Iterator[Finding]:
    """Report the limits of a barrel's core: its dimples, and its centring in the cavity."""
    points, sagitta = layout.positions[layout.on_dome], _sagitta(skin, layout)
    if _DEEPER * sagitta > spec.dot_depth:
        yield Finding(
            Severity.ERROR,
            "dimple-too-shallow",
            f"Under a dot of {layout.diameter:g} mm the core curves away by {sagitta:.2g} mm, too much for a dimple "
            f"{spec.dot_depth:g} mm deep.",
            f"Use a depth of at least {_DEEPER * sagitta:.2g} mm (--dot-depth), or smaller dots.",
        )
    floors = MarkerLayout(points - spec.dot_depth * skin.normal(points), layout.diameter)
    pair = floors.closest_pair()
    web = np.inf if pair is None else pair[2] - layout.diameter
    if web < spec.printer_wall:
        yield Finding(
            Severity.ERROR,
            "dimples-too-near",
            f"Two dimples of the core are {web:.2g} mm apart; the printer needs walls of {spec.printer_wall:g} mm.",
            f"Use dots below {layout.diameter + web - spec.printer_wall:.2g} mm, or fewer of them.",
        )
    share = spec.clearance / skin.thickness
    if share > _UNEVEN:
        yield Finding(
            Severity.ERROR if share > _TOUCHES else Severity.WARNING,
            "wall-uneven",
            f"The core is centred in the cavity within {spec.clearance:g} mm, {100 * share:.0f} % of a skin of "
            f"{skin.thickness:g} mm.",
            f"Use a thickness of at least {spec.clearance / _UNEVEN:g} mm, or less clearance.",
        )


def _check_pad(skin: Skin, layout: MarkerLayout, spec: ProcessSpec) -> Iterator[Finding]:
    points = layout.positions[layout.on_dome]
    slope = float(np.degrees(np.arccos(np.clip(skin.normal(points)[:, 2], -1, 1))).max())
    if slope > spec.max_slope_deg:
        yield Finding(
            Severity.WARNING,
            "pad-reach",
            f"The lowest dots lie on a slope of {slope:.3g}°; a pad prints up to {spec.max_slope_deg:g}°.",
            f"Keep dots within {_reached(skin, spec.max_slope_deg):.3g} mm of the axis.",
        )
    if spec.orientation_mark:
        points = np.vstack([points, place_orientation_mark(skin, layout)])
    if len(points) > 1:
        gap = _smallest_gap(
            project_to_page(skin, points, spec.mapping), project_dots(skin, points, layout.diameter, spec.mapping)
        )
        if gap < spec.min_gap:
            apart = f"are {gap:.2g} mm apart" if gap > 0 else f"overlap by {-gap:.2g} mm"
            yield Finding(
                Severity.WARNING if gap > 0 else Severity.ERROR,
                "dots-too-near",
                f"Two dots of the artwork, or a dot and the mark, {apart}; the pad needs {spec.min_gap:g} mm.",
                f"Use dots below {layout.diameter + gap - spec.min_gap:.2g} mm, or the mapping arc.",
            )


def _smallest_gap(centres: FloatArray, axes: FloatArray) -> float:
    """Return a lower bound in mm of the gaps between ellipses: that along the lines between their centres."""
    apart = centres[:, None] - centres[None]
    distance = np.linalg.norm(apart, axis=-1)
    np.fill_diagonal(distance, np.inf)
    extent = np.linalg.norm(np.einsum("ijk,iak->ija", apart, axes), axis=-1) / distance
    return float((distance - extent - extent.T).min())
