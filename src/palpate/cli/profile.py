"""`palpate design profile`: a skin from a drawn meridian."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.cli.output import Output, check_folder
from palpate.core import wrap_write_errors
from palpate.core.report import Report

if TYPE_CHECKING:
    from palpate.design import Profile

_FILE = (
    "Meridian of the inner surface: a table (r_mm, z_mm), a DXF drawing of the section with the axis at x = 0, or a "
    "STEP body of revolution. A drawn outer curve decides the thickness."
)
_THICKNESS = "Skin thickness if only the inner curve is drawn, mm."
_OUT = "Folder for the study (study.yaml) and the picture of drawing and skin (profile.png)."


def profile(
    file: Annotated[Path, Parameter(help=_FILE)],
    *,
    thickness: Annotated[float, Parameter(help=_THICKNESS)] = 2.0,
    out: Annotated[Path | None, Parameter(name=("--out", "-o"), help=_OUT)] = None,
    output: Output = Output(),
) -> None:
    """Find the skin that follows a drawn meridian, and write a study of it."""
    from palpate.design import read_profile

    check_folder(out)
    found = read_profile(file, thickness)
    values = describe_profile(found)
    if out is not None:
        out.mkdir(parents=True, exist_ok=True)
        with wrap_write_errors(out, "Choose another folder."):
            (out / "study.yaml").write_text(_study(found, file), encoding="utf-8")
        _draw(found, out / "profile.png")
    output.show(
        values,
        Report.of(str(file), ("quantity", "value"), list(_rows(found))),
        *([f"Study: {out / 'study.yaml'}. Picture: {out / 'profile.png'}."] if out is not None else []),
    )


def describe_profile(found: Profile) -> dict[str, Any]:
    """Return skin and deviations as JSON data."""
    return {
        "skin": found.spec.build().spec_data,
        "deviation_mm": found.deviation_mm,
        "thickness_drawn": bool(len(found.outer)),
        "thickness_deviation_mm": found.thickness_deviation_mm,
    }


def _rows(found: Profile) -> list[tuple[str, str]]:
    spec = found.spec
    rows = [
        ("height", f"{spec.height:.4g} mm"),
        ("base radius", f"{spec.base_radius:.4g} mm"),
        ("skin thickness", f"{spec.thickness:.4g} mm" + ("" if len(found.outer) else " (not drawn)")),
        ("points of the meridian", f"{len(spec.points)}"),
        ("maximum deviation from the drawing", f"{found.deviation_mm:.3f} mm"),
    ]
    if len(found.outer):
        rows.insert(3, ("thickness at the rim over apex", f"{spec.taper:.3g}"))
        rows.append(("maximum deviation of the thickness", f"{found.thickness_deviation_mm:.3f} mm"))
    return rows


def _study(found: Profile, file: Path) -> str:
    spec = found.spec
    points = ", ".join(f"[{rho:g}, {z:g}]" for rho, z in spec.points)
    taper = f", taper: {spec.taper:g}" if spec.taper != 1.0 else ""
    name = "".join(letter if letter.isalnum() and letter.isascii() else "_" for letter in file.stem)
    return f"""# The skin of {file.name}; the meridian follows the drawing within {found.deviation_mm:.3f} mm.
name: {name or "profile"}
designs:
  skin: {{kind: spline, points: [{points}]{taper}}}
  heights: [{spec.height:g} mm]
  base_radius: {spec.base_radius:g} mm
  thicknesses: [{spec.thickness:g} mm]
  markers: [37, 91]
"""


def _draw(found: Profile, path: Path) -> None:
    import numpy as np
    from matplotlib.figure import Figure

    skin, figure = found.spec.build(), Figure(figsize=(6.0, 5.0), layout="constrained")
    axes = figure.add_subplot()
    t = np.linspace(0.0, 1.0, 400)
    inner = skin.curve(t)
    way = np.gradient(inner, axis=0)
    normal = np.column_stack([-way[:, 1], way[:, 0]]) / np.linalg.norm(way, axis=1)[:, None]
    outer = inner + normal * skin.wall_thickness(t)[:, None]
    axes.fill(*np.vstack([inner, outer[::-1]]).T, color="#cfd8dc", label="skin")
    for drawn in (found.inner, found.outer):
        if len(drawn):
            axes.plot(*drawn.T, color="#c62828", linewidth=1.0, label="drawing" if drawn is found.inner else None)
    knots = np.array(found.spec.points) * [found.spec.base_radius, found.spec.height]
    axes.plot(*knots.T, "o", color="#1565c0", markersize=4, label="points of the meridian")
    axes.set(xlabel="distance from the axis (mm)", ylabel="height above the base (mm)", aspect="equal")
    axes.legend(frameon=False)
    with wrap_write_errors(path, "Choose another folder."):
        figure.savefig(path, dpi=160)
