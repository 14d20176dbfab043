"""Limits of the built parts: elastomer, gel, free travel, hidden markers, and interference of parts."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from itertools import combinations

import numpy as np

from palpate.camera import Camera
from palpate.core import PalpateError
from palpate.design import CadSolid, ContactModule, Finding, MarkerLayout, Severity
from palpate.fabrication.enclosure import Enclosure, free_travel
from palpate.fabrication.frame import BarrelFrame
from palpate.fabrication.mold import Mold
from palpate.fabrication.spec import ProcessSpec
from palpate.fabrication.window_plate import WindowPlate

_TOUCH_MM3 = 1e-3
"""Shared volume below which two parts only touch."""


def check_mold(mold: Mold, spec: ProcessSpec) -> Iterator[Finding]:
    """Report the amount of elastomer of a mold, and the highest point of its cavity."""
    volume = mold.hollow() / 1000
    yield Finding(
        Severity.NOTE,
        "elastomer",
        f"The mold takes {volume:.2f} mL.",
        f"Mix {volume * (1 + spec.excess_percent / 100):.1f} mL: {spec.excess_percent:g} % stay in the cup.",
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
    """Report the amount of gel that fills a skin, and the markers that the ledge of its window hides."""
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


def check_enclosure(module: ContactModule, enclosure: Enclosure, spec: ProcessSpec) -> Iterator[Finding]:
    """Report contact of the wall with the clamp ring before the sensor's working depth."""
    travel, is_tube = free_travel(module, enclosure, spec.working_tilt_deg), bool(module.skin.hole)
    if travel < spec.working_depth:
        low = enclosure.ring[0][1]
        within = f"press with a plate that ends between the rings, z = {low:g} to {module.skin.height - low:g} mm"
        remedy = within if is_tube else "take a higher dome"
        yield Finding(
            Severity.WARNING,
            "ring-in-the-way",
            f"A wall {'at the side, ' if is_tube else ''}inclined by {spec.working_tilt_deg:g}° meets the clamp ring "
            f"after {max(travel, 0.0) if is_tube else travel:.3g} mm of {spec.working_depth:g} mm.",
            f"Reduce the working depth or tilt, or {remedy} or a narrower flange.",
        )


def check_frame(frame: BarrelFrame, layout: MarkerLayout, camera: Camera) -> Iterator[Finding]:
    """Report the markers of a barrel that its rods hide from the camera, wholly or in part."""
    points = layout.positions[layout.on_dome]
    _, along, around = frame.module.skin.tangents(points)
    reach = layout.diameter / 2
    dots = [points + reach * side * way for way in (along, around) for side in (-1.0, 0.0, 1.0)]
    hidden = int(np.any([frame.hidden(camera.origin, dot) for dot in dots], axis=0).sum())
    if hidden:
        yield Finding(
            Severity.WARNING,
            "marker-behind-rod",
            f"The rods that carry the far end hide {hidden} of {len(layout)} markers from the camera, some in part.",
            "Use fewer columns, smaller dots, or a camera nearer to the base.",
        )


def check_interference(parts: dict[str, CadSolid], intended: Collection[frozenset[str]] = ()) -> None:
    """Raise an error if two parts of an assembly share volume, except the `intended` pairs.

    Raises
    ------
    PalpateError
        With the pair and the volume.
    """
    for (one, a), (other, b) in combinations(parts.items(), 2):
        if frozenset((one, other)) not in intended and (shared := a.overlap(b)) > _TOUCH_MM3:
            raise PalpateError(
                f"{one} and {other} share {shared:.3g} mm³ in the assembly.",
                "Change the dimensions of the process.",
                code="parts-overlap",
            )
