"""`palpate find` and `palpate live`: dots in images, and poses from images."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from palpate.camera import list_images, read_calibration, read_image
from palpate.cli.design import DesignFlags
from palpate.cli.flag import JsonFlag, flag
from palpate.cli.output import print_json, print_table
from palpate.core import PalpateError
from palpate.design import place_markers
from palpate.markers import DetectSpec, prepare_detector

if TYPE_CHECKING:
    from numpy.typing import NDArray

_FOLDER = "Folder of images."
_SOURCE = "Folder of images in order; the first ones show the untouched dome."
_MODEL = "Model of this design, an ONNX file."
_LENS = "YAML file of `palpate calibrate`; without it, the nominal camera's lens."
_OUT = "File for the readings, .csv or .jsonl."
_MARK = "Whether the orientation mark is printed."
_REST = "Number of images at rest at the beginning, which are averaged."


def find(
    folder: Annotated[Path, Parameter(help=_FOLDER)],
    *,
    polarity: Annotated[Literal["auto", "dark", "bright"], flag(DetectSpec, "polarity")] = "auto",
    method: Annotated[Literal["centroid", "opencv"], flag(DetectSpec, "method")] = "centroid",
    diameter: Annotated[float | None, flag(DetectSpec, "diameter_px", "--diameter")] = None,
    json: JsonFlag = False,
) -> None:
    """Find the dots of every image, with size, polarity and mask read from each."""
    spec = DetectSpec(polarity=polarity, method=method, diameter_px=diameter)
    rows: list[dict[str, Any]] = []
    for path in list_images(folder):
        try:
            image = read_image(path)
            detector = prepare_detector(image, spec)
            blobs = detector.find(image)
        except PalpateError as error:
            rows.append({"image": path.name, "dots": None, "reason": error.what})
            continue
        row = {"image": path.name, "dots": len(blobs), "polarity": "dark" if detector.dark else "bright"}
        row |= {"diameter_px": round(detector.diameter_px, 2), "noise": round(blobs.noise, 2), "reason": ""}
        rows.append(row | {"positions_px": blobs.positions_px.round(4).tolist()})
    if json:
        print_json(rows)
        return
    names = ["image", "dots", "polarity", "diameter_px", "noise", "reason"]
    print_table(str(folder), names, [[str(row.get(name, "") or "") for name in names] for row in rows])


@Parameter(name="*")
@dataclass(frozen=True)
class UnitFlags:
    """What `palpate live` may be told about the unit: its lens, mark and images at rest."""

    lens: Annotated[Path | None, Parameter(help=_LENS)] = None
    mark: Annotated[bool, Parameter(help=_MARK)] = True
    rest_images: Annotated[int, Parameter(help=_REST)] = 1


def live(
    *,
    model: Annotated[Path, Parameter(help=_MODEL)],
    source: Annotated[Path, Parameter(help=_SOURCE)],
    out: Annotated[Path | None, Parameter(help=_OUT)] = None,
    design: DesignFlags | None = None,
    flags: UnitFlags | None = None,
    json: JsonFlag = False,
) -> int:
    """Estimate the pose of the wall in every image of a recording, as if it came from the camera now."""
    from palpate.learn import open_predictor
    from palpate.sensor import Unit, describe_reading, open_sensor, run_sensor, write_readings

    design, flags = design or DesignFlags(), flags or UnitFlags()
    paths, rest = list_images(source), flags.rest_images
    if not 1 <= rest < len(paths):
        raise PalpateError(
            f"{rest} images at rest of {len(paths)} leave nothing to read.", "Give at least one of each."
        )
    dome = design.dome()
    lens = read_calibration(flags.lens).camera_spec() if flags.lens else None
    unit = Unit(dome, place_markers(dome, design.marker_spec()), marked=flags.mark, lens=lens)
    sensor = open_sensor([read_image(path) for path in paths[:rest]], unit, open_predictor(model))
    where = sensor.registration
    print(
        f"{sensor.naming.found.sum()} markers named; they fit the design to {where.rms_px:.3f} px.", file=sys.stderr
    )
    readings = run_sensor(sensor, _replay(paths[rest:]))
    rows = [describe_reading(reading) for reading in (write_readings(out, readings) if out else readings)]
    if json:
        print_json(rows)
    else:
        names = ["image", "rx_deg", "ry_deg", "depth_mm", "touching", "found", "latency_ms", "flags"]
        print_table(str(source), names, [[_show(row[name]) for name in names] for row in rows])
    return 0


def _replay(paths: tuple[Path, ...]) -> Iterator[NDArray[Any] | PalpateError]:
    for path in paths:
        try:
            yield read_image(path)
        except PalpateError as error:
            yield error


def _show(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.2f}"
    return "" if value is None else str(value)
