"""`palpate inspect`: the print errors of a built dome, from images of it at rest."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.camera import list_images, read_image
from palpate.cli.flag import JsonFlag, flags_of
from palpate.cli.output import check_file, print_json, print_table
from palpate.cli.unit import PrintFlags
from palpate.core import wrap_write_errors
from palpate.sensor import Inspection, InspectionSpec, draw_inspection, inspect_unit

if TYPE_CHECKING:
    from numpy.typing import NDArray

OUTSIDE = 1
"""Exit code where a dot is missing or out of place, as in `palpate verify`."""

_IMAGE = "Image of the finished, untouched dome, or a folder of several, which are averaged."
_OUT = "File for the table, .csv."
_PICTURE = "File for a picture of the errors, .png, .svg or .pdf."


def inspect(
    image: Annotated[Path, Parameter(help=_IMAGE)],
    *,
    built: PrintFlags = PrintFlags(),
    wanted: Annotated[InspectionSpec, flags_of(InspectionSpec)] = InspectionSpec(),
    out: Annotated[Path | None, Parameter(name=("--out", "-o"), help=_OUT)] = None,
    picture: Annotated[Path | None, Parameter(help=_PICTURE)] = None,
    json: JsonFlag = False,
) -> int:
    """Tell the print error of every marker against its nominal place."""
    check_file(out, ".csv")
    check_file(picture, ".png", ".svg", ".pdf")
    inspection = inspect_unit(_read_images(image), built.unit(), wanted)
    rows = _rows(inspection)
    if out:
        _write_table(out, rows)
    if picture:
        _write_picture(picture, inspection)
    if json:
        law = inspection.distortion
        shown = {"passed": inspection.passed, "rms_px": inspection.registration.rms_px, "markers": rows}
        print_json(shown | ({"rings": _rings(inspection), "law_rms_px": law.rms_px} if law else {}))
    else:
        _print(str(image), inspection, rows)
    return 0 if inspection.passed else OUTSIDE


def _read_images(place: Path) -> list[NDArray[Any]]:
    return [read_image(path) for path in (list_images(place) if place.is_dir() else (place,))]


def _rows(inspection: Inspection) -> list[dict[str, Any]]:
    layout, error, distance = inspection.unit.layout, inspection.error, inspection.distance
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
        return "no dot"
    return "outside" if number in inspection.outside else "within"


def _print(title: str, inspection: Inspection, rows: list[dict[str, Any]]) -> None:
    print_table(title, list(rows[0]), [["" if cell is None else str(cell) for cell in row.values()] for row in rows])
    distance = inspection.distance[~(inspection.distance != inspection.distance)]
    print(
        f"{len(distance)} of {len(rows)} dots found; rms {float((distance**2).mean()) ** 0.5:.3f} mm, "
        f"greatest {float(distance.max()):.3f} mm; {len(inspection.outside)} beyond {inspection.tolerance:g} mm. "
        f"The image fits to {inspection.registration.rms_px:.3f} px."
    )
    _print_law(inspection)


def _rings(inspection: Inspection) -> list[dict[str, Any]]:
    """A row for each ring of a bent print: as designed, as found, and where."""
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


def _print_law(inspection: Inspection) -> None:
    rows, law = _rings(inspection), inspection.distortion
    if law is None:
        return
    print_table("Rings", list(rows[0]), [[str(cell) for cell in row.values()] for row in rows])
    print(
        f"The print is bent as a whole: its rings are {law.growth.min() - 1.0:+.1%} to {law.growth.max() - 1.0:+.1%} "
        f"of the design's radius. With this law the image fits to {law.rms_px:.2f} px."
    )


def _write_table(path: Path, rows: list[dict[str, Any]]) -> None:
    with wrap_write_errors(path), path.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(rows[0]))
        table.writeheader()
        table.writerows(rows)


def _write_picture(path: Path, inspection: Inspection) -> None:
    with wrap_write_errors(path):
        draw_inspection(inspection).savefig(path, dpi=150)
