"""Limits of a design in the workshop, each a finding with its number."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from palpate.cad import CadSolid
from palpate.camera import Camera
from palpate.core import PalpateError
from palpate.design import (
    Finding,
    MarkerLayout,
    Module,
    Severity,
    Skin,
    check_design,
)
from palpate.fabricate.artwork import flatten
from palpate.fabricate.enclosure import Enclosure, free_travel
from palpate.fabricate.mold import Mold
from palpate.fabricate.spec import ProcessSpec
from palpate.fabricate.window_plate import WindowPlate
from palpate.material import Material

_SAGITTA = 0.03
"""Height of a dot's cap over its diameter beyond which the pad smears its edge."""
_SMALLEST_PX = 5.0
"""Diameter of a dot's image below which its centre is uncertain."""
_SLENDER = 5.0
"""Length of a pin over its diameter that still comes out of the core whole; our choice."""
_PEEL = 0.5
"""Share of the material's greatest stretch that peeling may ask for."""
_TOUCH_MM3 = 1e-3
"""Shared volume below which two parts only touch."""
_PEEL_UNKNOWN = 2.0
"""Stretch that every soft silicone bears, where the material gives no range."""


def check_process(
    skin: Skin, layout: MarkerLayout, material: Material, camera: Camera, spec: ProcessSpec
) -> tuple[Finding, ...]:
    """Report what the workshop meets with a design: demolding, dots, pad and camera; errors first."""
    findings = [
        *check_design(skin, layout),
        *_check_wall(skin),
        *_check_peeling(skin, material),
        *_check_dots(skin, layout, camera, spec),
        *(_check_pins(skin, layout) if skin.pin else _check_pad(skin, layout, spec)),
    ]
    order = list(Severity)
    return tuple(sorted(findings, key=lambda finding: order.index(finding.severity)))


def check_mold(mold: Mold, spec: ProcessSpec) -> Iterator[Finding]:
    """Report what is known once the mold is built: elastomer, and the highest point of the hollow."""
    volume = mold.hollow() / 1000
    yield Finding(
        Severity.NOTE,
        "elastomer",
        f"The mold holds {volume:.2f} mL.",
        f"Mix {volume * (1 + spec.excess_percent / 100):.1f} mL: {spec.excess_percent:g} % stay in cup and sprues.",
    )
    yield Finding(
        Severity.NOTE,
        "vents",
        f"{spec.vents} vents and the pour hole end on the flange, the highest part of the hollow.",
        "Pour slowly into the hole until elastomer stands in every vent.",
    )


def check_window(
    window: WindowPlate, layout: MarkerLayout, gel: str, camera: Camera, spec: ProcessSpec
) -> Iterator[Finding]:
    """Report how much gel fills a skin, and which markers the ledge of its window hides."""
    volume = window.gel_mm3 / 1000
    yield Finding(
        Severity.NOTE,
        "gel",
        f"Between skin and window are {volume:.2f} mL of {gel}.",
        f"Mix {volume * (1 + spec.excess_percent / 100):.1f} mL: {spec.excess_percent:g} % stay in the cup and "
        "around the window.",
    )
    way = camera.back_project(camera.project(layout.positions[layout.on_dome]))
    below = -window.thickness - camera.origin[2]
    enters = camera.origin[:2] + below * way[:, :2] / way[:, 2:]
    hidden = int((window.skin.plan.pseudo_radius(enters) > window.opening).sum())
    if hidden:
        yield Finding(
            Severity.WARNING,
            "marker-behind-ledge",
            f"The ledge under the window, open to {window.opening:.4g} mm along x, hides {hidden} of {len(layout)} "
            "markers.",
            "Move them inward, or the camera back.",
        )


def _check_wall(skin: Skin) -> Iterator[Finding]:
    if skin.thickness >= skin.radius:
        yield Finding(
            Severity.ERROR,
            "not-a-shell",
            f"A wall of {skin.thickness:g} mm on an inner radius of {skin.radius:.4g} mm is no shell to be molded.",
            f"Take less than {skin.radius:.4g} mm.",
        )


def _check_peeling(skin: Skin, material: Material) -> Iterator[Finding]:
    if not skin.bulges:
        return
    stretch, depth = skin.widest[0] / skin.base_radius, skin.widest[0] - skin.base_radius
    known = np.isfinite(material.stretch_range[1])
    limit = 1 + _PEEL * (material.stretch_range[1] - 1) if known else _PEEL_UNKNOWN
    where = f"the part must stretch {stretch:.3g} times to be peeled off the core (undercut {depth:.3g} mm)"
    if stretch > limit:
        yield Finding(
            Severity.ERROR,
            "peel-stretch",
            f"The dome bulges over its base, so {where}; it bears {limit:.3g} safely.",
            f"Take a height below {skin.height * limit / stretch:.3g} mm or a wider base.",
        )
    else:
        yield Finding(
            Severity.WARNING,
            "peel-stretch",
            f"The dome bulges over its base, so {where}.",
            "The cavity is made in halves; wet the core with soapy water and peel from the flange.",
        )


def _check_dots(skin: Skin, layout: MarkerLayout, camera: Camera, spec: ProcessSpec) -> Iterator[Finding]:
    diameter = layout.diameter
    if diameter < spec.smallest_dot:
        yield Finding(
            Severity.ERROR,
            "dot-too-small",
            f"Dots are {diameter:g} mm wide, the pad prints from {spec.smallest_dot:g} mm on.",
            f"Take dots of at least {spec.smallest_dot:g} mm.",
        )
    points = layout.positions[layout.on_dome]
    _, along, around = skin.tangents(points)
    sagitta = float(np.abs([skin.distance(points + diameter / 2 * way) for way in (along, around)]).max())
    if sagitta > _SAGITTA * diameter and not skin.pin:
        yield Finding(
            Severity.WARNING,
            "dot-on-curve",
            f"A dot of {diameter:g} mm is a cap {sagitta:.2g} mm high on an inner radius of {skin.radius:.3g} mm.",
            f"Take dots below {8 * skin.radius * _SAGITTA:.2g} mm, or a flatter dome.",
        )
    beside = points + np.array([diameter, 0.0, 0.0])
    size = np.linalg.norm(camera.project(beside) - camera.project(points), axis=1)
    if size.min() < _SMALLEST_PX:
        yield Finding(
            Severity.WARNING,
            "dot-in-pixels",
            f"The smallest dot is {size.min():.2g} pixels wide in the camera.",
            f"Take dots of at least {diameter * _SMALLEST_PX / size.min():.2g} mm, or a camera nearer or sharper.",
        )
    unseen = ~camera.visible(points, skin)
    if unseen.any():
        yield Finding(
            Severity.WARNING,
            "marker-unseen",
            f"The camera does not see {int(unseen.sum())} of {len(points)} markers.",
            "Move the camera back, or take a wider lens.",
        )


def _reached(skin: Skin, steepest_deg: float) -> float:
    """Distance in mm from the axis to which the inner surface is no steeper than so many degrees."""
    s = np.linspace(0.0, 1.0, 2001)
    points = skin.point(np.column_stack([s, 0.0 * s]), 0.0)
    level = skin.normal(points)[:, 2] >= np.cos(np.radians(steepest_deg))
    return float(points[level, 0].max())


def _check_pins(skin: Skin, layout: MarkerLayout) -> Iterator[Finding]:
    """Limits of pins that are cast with the wall."""
    if skin.pin > _SLENDER * layout.diameter:
        yield Finding(
            Severity.WARNING,
            "pins-slender",
            f"A pin {skin.pin:g} mm long is {layout.diameter:g} mm wide: it may tear in the core.",
            f"Take pins of at most {_SLENDER * layout.diameter:.3g} mm, or wider ones.",
        )


def _check_pad(skin: Skin, layout: MarkerLayout, spec: ProcessSpec) -> Iterator[Finding]:
    points = layout.positions[layout.on_dome]
    slope = float(np.degrees(np.arccos(np.clip(skin.normal(points)[:, 2], -1, 1))).max())
    if slope > spec.steepest_deg:
        yield Finding(
            Severity.WARNING,
            "pad-reach",
            f"The lowest dots lie on a slope of {slope:.3g}°, a pad reaches {spec.steepest_deg:g}°.",
            f"Keep dots within {_reached(skin, spec.steepest_deg):.3g} mm of the axis.",
        )
    page = flatten(skin, points, spec.mapping)
    if len(page) > 1:
        distance = np.linalg.norm(page[:, None] - page[None], axis=-1)
        np.fill_diagonal(distance, np.inf)
        gap = float(distance.min()) - layout.diameter
        if gap < spec.smallest_gap:
            yield Finding(
                Severity.WARNING if gap > 0 else Severity.ERROR,
                "dots-too-near",
                f"Two dots of the artwork stand {gap:.2g} mm apart, the pad keeps {spec.smallest_gap:g} mm.",
                f"Take dots below {layout.diameter + gap - spec.smallest_gap:.2g} mm, or the mapping arc.",
            )


def check_enclosure(module: Module, enclosure: Enclosure, spec: ProcessSpec) -> Iterator[Finding]:
    """Report where the wall meets the clamp ring before the sensor's working depth."""
    travel = free_travel(module, enclosure, spec.working_tilt_deg)
    if travel < spec.working_depth:
        yield Finding(
            Severity.WARNING,
            "ring-in-the-way",
            f"A wall inclined by {spec.working_tilt_deg:g}° meets the clamp ring after {travel:.3g} mm of "
            f"{spec.working_depth:g} mm.",
            "Work less deep or less inclined, or take a higher dome or a narrower flange.",
        )


def refuse_interference(parts: dict[str, CadSolid], intended: frozenset[str] = frozenset()) -> None:
    """Stop where two parts of an assembly share volume; the pair `intended` may.

    Raises
    ------
    PalpateError
        With the pair and the volume.
    """
    for (one, a), (other, b) in combinations(parts.items(), 2):
        if frozenset((one, other)) != intended and (shared := a.overlap(b)) > _TOUCH_MM3:
            raise PalpateError(
                f"{one} and {other} share {shared:.3g} mm³ when they are put together.",
                "Change the dimensions of the process.",
            )
