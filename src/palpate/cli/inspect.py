"""`palpate calibration inspect`: print errors of a built unit from its rest images."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.cli.border import OUTSIDE
from palpate.cli.flag import flags_of
from palpate.cli.output import Output, check_file
from palpate.cli.unit import PrintFlags
from palpate.core import wrap_write_errors
from palpate.core.report import Column, Report, write_csv
from palpate.sensor import InspectionSpec

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from palpate.sensor import Inspection


_COLUMNS = (
    Column("marker"),
    *(Column(f"{axis}_mm", form=".4f", meaning="nominal position", deciding=False) for axis in "xyz"),
    Column("meridian_mm", "error along the meridian", form=".4f"),
    Column("ring_mm", "error along the ring", form=".4f"),
    Column("distance_mm", "error", form=".4f", meaning="distance from the nominal position"),
    Column("mm_per_px", "resolution", "mm/px", form=".4f", deciding=False),
    Column("verdict"),
)
_RINGS = (
    Column("ring"),
    Column("dots", "markers"),
    Column("designed_mm", "design radius", form=".3f"),
    Column("found_mm", "radius", form=".3f"),
    Column("growth", form=".4f", meaning="radius over the design radius"),
    Column("centre_x_mm", form=".3f", deciding=False),
    Column("centre_y_mm", form=".3f", deciding=False),
    Column("flatness", form=".4f", meaning="ellipticity of the ring", deciding=False),
    Column("flat_deg", "direction of the short axis", form=".1f", deciding=False),
    Column("turn_deg", "rotation", form=".2f"),
)
_IMAGE = "Image of the finished, unloaded skin, or a folder of such images, which are averaged."
_OUT = "File of the table, .csv."
_PICTURE = "File of a figure of the errors, .png, .svg or .pdf."


def inspect(
    image: Annotated[Path, Parameter(help=_IMAGE)],
    *,
    built: PrintFlags = PrintFlags(),
    wanted: Annotated[InspectionSpec, flags_of(InspectionSpec)] = InspectionSpec(),
    out: Annotated[Path | None, Parameter(name=("--out", "-o"), help=_OUT)] = None,
    picture: Annotated[Path | None, Parameter(help=_PICTURE)] = None,
    output: Output = Output(),
) -> int:
    """Measure the print error of every marker: its distance from the nominal position."""
    from palpate.sensor import inspect_unit

    check_file(out, ".csv")
    check_file(picture, ".png", ".svg", ".pdf")
    inspection = inspect_unit(_read_images(image), built.unit(), wanted)
    rows = _rows(inspection)
    if out:
        write_csv(out, rows, list(rows[0]))
    if picture:
        _write_picture(picture, inspection)
    law = inspection.distortion
    shown = {"passed": inspection.passed, "rms_px": inspection.registration.rms_px, "markers": rows}
    shown |= {"rings": _rings(inspection), "law_rms_px": law.rms_px} if law else {}
    output.show(shown, *_reports(Report(str(image), _COLUMNS, rows, file=str(out or "")), inspection))
    return 0 if inspection.passed else OUTSIDE


def _read_images(place: Path) -> list[NDArray[Any]]:
    from palpate.camera import list_images, read_image

    return [read_image(path) for path in (list_images(place) if place.is_dir() else (place,))]


def _rows(inspection: Inspection) -> list[dict[str, Any]]:
    layout, error, distance = inspection.unit.design.layout, inspection.error, inspection.distance
    return [
        {
            "marker": number,
            **dict(zip(("x_mm", "y_mm", "z_mm"), (round(float(value), 4) for value in place), strict=True)),
            **_measured(error[number], float(distance[number])),
            "mm_per_px": round(float(inspection.mm_per_px[number]), 4),
            "verdict": _verdict(inspection, number),
        }
        for number, place in enumerate(layout.positions)
    ]


def _measured(error: NDArray[Any], distance: float) -> dict[str, float | None]:
    values = zip(("meridian_mm", "ring_mm", "distance_mm"), (*error, distance), strict=True)
    return {name: round(float(value), 4) if value == value else None for name, value in values}


def _verdict(inspection: Inspection, number: int) -> str:
    if number in inspection.missing:
        return "missing"
    return "outside" if number in inspection.outside else "within"


def _reports(markers: Report, inspection: Inspection) -> Iterator[Report | str]:
    if scaled := inspection.unit.describe_scaling(inspection.registration.camera.spec):
        yield scaled
    yield markers
    distance = inspection.distance[~(inspection.distance != inspection.distance)]
    yield (
        f"{len(distance)} of {len(markers.rows)} markers found; RMS error "
        f"{float((distance**2).mean()) ** 0.5:.3f} mm, maximum {float(distance.max()):.3f} mm; "
        f"{len(inspection.outside)} beyond {inspection.tolerance:g} mm. "
        f"RMS residual of the registration: {inspection.registration.rms_px:.3f} px."
    )
    law = inspection.distortion
    if law is not None:
        yield Report("rings", _RINGS, _rings(inspection))
        yield (
            "The whole print is distorted: the radii of its rings differ by "
            f"{law.growth.min() - 1.0:+.1%} to {law.growth.max() - 1.0:+.1%} from the design. With the ring "
            f"model, the RMS residual is {law.rms_px:.2f} px."
        )


def _rings(inspection: Inspection) -> list[dict[str, Any]]:
    """Return a row per ring of a distorted print: design radius, measured radius and position."""
    law = inspection.distortion
    if law is None:
        return []
    return [
        {
            "ring": number + 1,
            "dots": len(law.rings.members(number + 1)),
            "designed_mm": round(float(law.rings.rho[number + 1]), 3),
            "found_mm": round(float(law.radius[number]), 3),
            "growth": round(float(law.growth[number]), 4),
            "centre_x_mm": round(float(law.centre[number, 0]), 3),
            "centre_y_mm": round(float(law.centre[number, 1]), 3),
            "flatness": round(float(law.flatness[number]), 4),
            "flat_deg": round(float(law.flat_deg[number]), 1),
            "turn_deg": round(float(law.turn_deg[number]), 2),
        }
        for number in range(len(law.rings))
    ]


def _write_picture(path: Path, inspection: Inspection) -> None:
    from palpate.sensor import draw_inspection

    with wrap_write_errors(path):
        draw_inspection(inspection).savefig(path, dpi=150)
