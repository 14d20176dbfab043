"""`palpate sensor detect` and `palpate sensor live`: markers in images, and poses from images."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain, islice
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.camera import Source, list_images, open_source, read_image
from palpate.cli.compiling import announce_compilation
from palpate.cli.flag import flags_of
from palpate.cli.output import JsonOutput, Output, check_file, check_folder, print_text
from palpate.cli.unit import ModelFlags, UnitFlags, open_printing_scale
from palpate.core import PalpateError
from palpate.core.report import EMPTY, Column, Report
from palpate.design import Design, PoseSpace
from palpate.sensor import SensorSpec
from palpate.vision import DetectSpec

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from palpate.learn import RecordedModel
    from palpate.sensor import ReferencePress, Sensor, Unit

_COLUMNS = (
    Column("image"),
    Column("dots", "markers", meaning="detected markers"),
    Column("polarity"),
    Column("diameter_px", form="g", meaning="median diameter of a marker"),
    Column("noise", form="g", meaning="standard deviation of the grey values"),
    Column("reason", prose=True, meaning="reason for no detection"),
)
_WIDTH = 7
"""Minimum width of a column of readings, which are printed one by one."""
_FOLDER = "Folder of images."
_SOURCE = (
    "Number of a camera, a video, an .aedat4 recording, a folder of images in order, or 'synthetic' (simulated "
    "images). The first images must show the unloaded skin."
)
_OUT = "File of the readings, .csv or .jsonl, or a new folder .rosbag2."
_PRESS_IMAGE = "Image of a press of known pose; it resolves the marker assignment without an orientation mark."
_PRESS_POSE = "Pose of that press: rx and ry in degrees, depth in mm (within 1 mm), such as --press-pose 6 1.5 4."
_COUNT = "Number of readings; by default until the source ends."


def find(
    folder: Annotated[Path, Parameter(help=_FOLDER)],
    *,
    spec: Annotated[DetectSpec, flags_of(DetectSpec)] = DetectSpec(),
    output: Output = Output(),
) -> None:
    """Detect the markers of every image; marker size, polarity and mask are estimated from each image."""
    from palpate.vision import prepare_detector

    rows: list[dict[str, Any]] = []
    for path in list_images(folder):
        try:
            image = read_image(path)
            detector = prepare_detector(image, spec)
            blobs = detector.find(image)
        except PalpateError as error:
            rows.append({"image": path.name, "dots": None, "reason": error.problem})
            continue
        row = {"image": path.name, "dots": len(blobs), "polarity": "dark" if detector.dark else "bright"}
        row |= {"diameter_px": round(detector.diameter_px, 2), "noise": round(blobs.noise, 2), "reason": ""}
        rows.append(row | {"positions_px": blobs.positions_px.round(4).tolist()})
    output.show(rows, Report(str(folder), _COLUMNS, rows))


@Parameter(name="*")
@dataclass(frozen=True)
class LiveFlags:
    """Unit, settings of the readings, reference press and number of readings."""

    built: UnitFlags = UnitFlags()
    rig: Annotated[SensorSpec, flags_of(SensorSpec, group="Readings")] = SensorSpec()
    press_image: Annotated[Path | None, Parameter(help=_PRESS_IMAGE)] = None
    press_pose: Annotated[tuple[float, float, float] | None, Parameter(help=_PRESS_POSE, negative="")] = None
    count: Annotated[int | None, Parameter(help=_COUNT)] = None


def live(
    *,
    source: Annotated[str, Parameter(help=_SOURCE)],
    reads: ModelFlags = ModelFlags(),
    out: Annotated[Path | None, Parameter(name=("--out", "-o"), help=_OUT)] = None,
    flags: LiveFlags = LiveFlags(),
    output: JsonOutput = JsonOutput(),
) -> int:
    """Estimate the pose of the obstacle in every image of a camera or a recording."""
    from palpate.learn import is_recorded_model, read_model
    from palpate.sensor import describe_reading, open_model, run_sensor, write_readings

    if flags.count is not None and flags.count < 1:
        raise PalpateError(
            f"--count is {flags.count}.", "Give 1 or more, or leave it out.", code="option-out-of-bounds"
        )
    if out is not None and out.suffix == ".rosbag2":
        check_folder(out)
    else:
        check_file(out, ".csv", ".jsonl", ".rosbag2")
    check_source(source)
    model = reads.find(flags.built)
    if is_recorded_model(model):
        return _live_recorded(read_model(model), source, out, flags, output.json)
    unit, many = flags.built.unit(reads.material), flags.rig.rest_images
    reads_with = open_model(model, unit.design.skin)
    with open_images(source, unit) as opened:
        images = opened.images()
        sensor = open_printing_scale(
            _at_rest(images, many), unit, reads_with, flags.rig, reference_press=_known_press(flags, unit.design)
        )
        sensor.clock = opened.clock
        print(_describe_rest(sensor), file=sys.stderr)
        first = next(images, None)
        if first is None:
            raise PalpateError(
                f"The source ends after its {many} rest images.",
                "Record images of presses, too, or lower --rest-images.",
                code="rest-images-leave-none",
            )
        readings = run_sensor(sensor, islice(chain([first], images), flags.count))
        written = write_readings(out, readings, sensor.estimator.space) if out else readings
        rows = (describe_reading(reading) for reading in written)
        _print_json(rows) if output.json else _print_lines(rows, sensor.estimator.space)
        if sensor.rest is not None:
            print(sensor.rest.summary(), file=sys.stderr)
    return 0


def _live_recorded(model: RecordedModel, source: str, out: Path | None, flags: LiveFlags, json: bool) -> int:
    """Print readings by the model of a recording, of every image: the model contains its rest state."""
    from palpate.sensor import describe_reading, run_sensor, write_readings

    if source == "synthetic":
        raise PalpateError(
            "A model of a recording has no design, so its images cannot be simulated.",
            "Give a camera, a video or a folder.",
            code="model-no-design",
        )
    with open_source(source) as opened:
        readings = run_sensor(model, islice(opened.images(), flags.count), flags.rig)
        written = write_readings(out, readings, model.space) if out else readings
        rows = (describe_reading(reading) for reading in written)
        _print_json(rows) if json else _print_lines(rows, model.space)
    return 0


def check_source(source: str) -> None:
    """Reject a missing file before the search of a twin, with the error of `open_source`."""
    if Path(source).suffix and not Path(source).exists():
        open_source(source).close()


def open_images(source: str, unit: Unit) -> Source:
    """Open a source of images, or the simulated sensor of a unit for ``synthetic``."""
    if source != "synthetic":
        return open_source(source)
    from palpate.simulation import simulate_sensor

    announce_compilation()
    return simulate_sensor(unit)


def _describe_rest(sensor: Sensor) -> str:
    where = sensor.registration
    sentence = f"{sensor.assignment.found.sum()} markers assigned; RMS residual {where.rms_px:.3f} px"
    if not sensor.spec.refine_lens:
        return sentence + "."
    lens, (focal, column, row) = where.camera.spec, where.lens_sd
    return (
        f"{sentence}, {where.held_rms_px:.3f} px with the calibrated lens. Refined lens: focal length "
        f"{lens.fx_px:.1f} px (± {focal:.1%}), centre {lens.cx_px:.1f}, {lens.cy_px:.1f} px "
        f"(± {column:.1f}, {row:.1f})."
    )


def _known_press(flags: LiveFlags, design: Design) -> ReferencePress | None:
    if flags.press_image is None and flags.press_pose is None:
        return None
    if flags.press_image is None or flags.press_pose is None:
        raise PalpateError(
            "A reference press needs an image and its pose; only one of them was given.",
            "Give --press-image and --press-pose.",
            code="press-pose-incomplete",
        )
    from palpate.sensor import ReferencePress

    image = read_image(flags.press_image)
    announce_compilation()
    return ReferencePress.simulate(image, flags.press_pose, design)


def _at_rest(images: Iterator[NDArray[Any] | PalpateError], count: int) -> list[NDArray[Any]]:
    rest = []
    for image in islice(images, count):
        if isinstance(image, PalpateError):
            raise image
        rest.append(image)
    if len(rest) < count:
        raise PalpateError(
            f"The source has {len(rest)} images, and {count} rest images are required.",
            "Record more images, or lower --rest-images.",
            code="rest-images-leave-none",
        )
    return rest


def _print_json(rows: Iterator[dict[str, Any]]) -> None:
    """Print a JSON list, each member as soon as it is available."""
    print("[", end="")
    for number, row in enumerate(rows):
        print(("," if number else "") + "\n  " + dumps(row), end="", flush=True)
    print("\n]")


def _print_lines(rows: Iterator[dict[str, Any]], space: PoseSpace) -> None:
    """Print one line per reading as soon as it is available; readings are not stored."""
    names = ["image", *space.names, "touching", "found", "latency_ms", "flags"]
    print(" ".join(f"{name:>{_WIDTH}}" for name in names))
    for row in rows:
        pose = dict.fromkeys(space.names, EMPTY) if row["touching"] is False else {}  # no wall, no pose
        cells = [pose.get(name, _show(row[name])).rjust(max(_WIDTH, len(name))) for name in names]
        reason = f" ({row['reason']})" if row["reason"] else ""
        print_text(" ".join(cells).rstrip() + reason)


def _show(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.2f}"
    return "" if value is None else str(value)
