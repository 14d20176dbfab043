"""`palpate design`: radius, shape, marker positions and limits of one design."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from palpate.cli.flag import JsonFlag
from palpate.cli.output import print_json, print_table
from palpate.cli.unit import DomeFlags, MarkerFlags
from palpate.design import (
    Dome,
    DomeSpec,
    Finding,
    MarkerLayout,
    MarkerSpec,
    build_dome,
    check_design,
    place_markers,
)


def design(*, dome: DomeFlags = DomeSpec(), markers: MarkerFlags = MarkerSpec(), json: JsonFlag = False) -> None:
    """Radius, shape, marker positions and limits of one design."""
    built = build_dome(dome)
    layout = place_markers(built, markers)
    findings = check_design(built, layout)
    if json:
        print_json(_describe(built, layout, findings))
        return
    print(
        f"{built.shape}: height {built.height:g} mm, base radius {built.base_radius:g} mm, "
        f"thickness {built.thickness:g} mm\n"
        f"inner radius {built.radius:.4g} mm, outer radius {built.outer_radius:.4g} mm, "
        f"centre at z = {built.center_z:.4g} mm"
    )
    rows = [[str(i), *(f"{value:.3f}" for value in point)] for i, point in enumerate(layout.positions)]
    print_table(f"{len(layout)} markers of {layout.diameter:g} mm", ["marker", "x mm", "y mm", "z mm"], rows)
    for finding in findings:
        print(f"{finding.severity}: {finding.message} {finding.remedy}")


def _describe(dome: Dome, layout: MarkerLayout, findings: tuple[Finding, ...]) -> dict[str, Any]:
    return {
        "height_mm": dome.height,
        "base_radius_mm": dome.base_radius,
        "thickness_mm": dome.thickness,
        "radius_mm": dome.radius,
        "outer_radius_mm": dome.outer_radius,
        "center_z_mm": dome.center_z,
        "shape": str(dome.shape),
        "markers": len(layout),
        "marker_diameter_mm": layout.diameter,
        "positions_mm": layout.positions.tolist(),
        "findings": [asdict(finding) for finding in findings],
    }
