"""`palpate design`: radius, shape, marker positions and limits of one design."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from palpate.cli.flag import JsonFlag
from palpate.cli.output import print_json, print_table
from palpate.cli.unit import DesignFlags
from palpate.design import (
    Finding,
    MarkerLayout,
    Skin,
    build_skin,
    check_design,
    place_markers,
)


def design(*, flags: DesignFlags = DesignFlags(), json: JsonFlag = False) -> None:
    """Radius, shape, marker positions and limits of one design."""
    built = build_skin(flags.skin_spec())
    layout = place_markers(built, flags.markers)
    findings = check_design(built, layout)
    if json:
        print_json(_describe(built, layout, findings))
        return
    print(
        f"{built.shape}: height {built.height:g} mm, base radius {built.base_radius:g} mm, "
        f"thickness {built.thickness:g} mm\n"
        f"inner radius {built.radius:.4g} mm at the apex, widest inside {2 * built.widest[0]:.4g} mm at "
        f"z = {built.widest[1]:.4g} mm"
    )
    rows = [[str(i), *(f"{value:.3f}" for value in point)] for i, point in enumerate(layout.positions)]
    print_table(f"{len(layout)} markers of {layout.diameter:g} mm", ["marker", "x mm", "y mm", "z mm"], rows)
    for finding in findings:
        print(f"{finding.severity}: {finding.message} {finding.remedy}")


def _describe(skin: Skin, layout: MarkerLayout, findings: tuple[Finding, ...]) -> dict[str, Any]:
    return {
        "height_mm": skin.height,
        "base_radius_mm": skin.base_radius,
        "thickness_mm": skin.thickness,
        "radius_mm": skin.radius,
        "widest_mm": 2 * skin.widest[0],
        "widest_at_z_mm": skin.widest[1],
        "shape": str(skin.shape),
        "markers": len(layout),
        "marker_diameter_mm": layout.diameter,
        "positions_mm": layout.positions.tolist(),
        "findings": [asdict(finding) for finding in findings],
    }
