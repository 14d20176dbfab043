"""`palpate design show`: radius, shape, marker positions and limits of one design."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from palpate.cli.output import Output
from palpate.cli.unit import DesignFlags
from palpate.core.report import Column, Report
from palpate.design import (
    Finding,
    MarkerLayout,
    Skin,
    build_skin,
    check_design,
    place_markers,
)


def design(*, flags: DesignFlags = DesignFlags(), output: Output = Output()) -> None:
    """Show radius, shape, marker positions and limits of one design."""
    built = build_skin(flags.skin_spec())
    layout = place_markers(built, flags.markers)
    findings = check_design(built, layout)
    shape = (
        f"{built.shape}: height {built.height:g} mm, base radius {built.base_radius:g} mm, "
        f"thickness {built.thickness:g} mm\n"
        f"inner radius {built.radius:.4g} mm at the apex, widest inside {2 * built.widest[0]:.4g} mm at "
        f"z = {built.widest[1]:.4g} mm"
    )
    columns = [Column("marker"), *(Column(f"{axis}_mm", form=".3f") for axis in "xyz")]
    rows = ((number, *map(float, point)) for number, point in enumerate(layout.positions))
    output.show(
        _describe(built, layout, findings),
        shape,
        Report.of(f"{len(layout)} markers of {layout.diameter:g} mm", columns, rows),
        *(f"{finding.severity}: {finding.message} {finding.remedy}" for finding in findings),
    )


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
