"""`palpate design`: radius, shape, marker positions and limits of one design."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from palpate.cli.flag import JsonFlag, default, flag
from palpate.cli.output import print_json, print_table
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


@Parameter(name="*")
@dataclass(frozen=True)
class DesignFlags:
    """What `palpate design` may be told."""

    height: Annotated[float, flag(DomeSpec, "height")] = default(DomeSpec, "height")
    thickness: Annotated[float, flag(DomeSpec, "thickness")] = default(DomeSpec, "thickness")
    base_radius: Annotated[float, flag(DomeSpec, "base_radius")] = default(DomeSpec, "base_radius")
    markers: Annotated[int | None, flag(MarkerSpec, "count")] = None
    rings: Annotated[tuple[float, ...] | None, flag(MarkerSpec, "ring_diameters")] = None
    layout: Annotated[Path | None, flag(MarkerSpec, "file")] = None
    marker_diameter: Annotated[float, flag(MarkerSpec, "diameter")] = default(MarkerSpec, "diameter")

    def dome(self) -> Dome:
        """The dome of these flags."""
        return build_dome(DomeSpec(height=self.height, base_radius=self.base_radius, thickness=self.thickness))

    def marker_spec(self) -> MarkerSpec:
        """The layout of these flags; only what was said counts as chosen."""
        chosen = {"count": self.markers, "ring_diameters": self.rings, "file": self.layout}
        said = {name: value for name, value in chosen.items() if value is not None}
        return MarkerSpec(diameter=self.marker_diameter, **said)  # type: ignore[arg-type]


def design(*, flags: DesignFlags | None = None, json: JsonFlag = False) -> None:
    """Radius, shape, marker positions and limits of one design."""
    flags = flags or DesignFlags()
    dome = flags.dome()
    layout = place_markers(dome, flags.marker_spec())
    findings = check_design(dome, layout)
    if json:
        print_json(_describe(dome, layout, findings))
        return
    print(
        f"{dome.shape}: height {dome.height:g} mm, base radius {dome.base_radius:g} mm, "
        f"thickness {dome.thickness:g} mm\n"
        f"inner radius {dome.radius:.4g} mm, outer radius {dome.outer_radius:.4g} mm, "
        f"centre at z = {dome.center_z:.4g} mm"
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
