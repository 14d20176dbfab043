"""`palpate calibration camera`: calibration of a camera from images of a board, or the board as PDF."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.camera import CalibrationSpec, read_board
from palpate.cli.flag import flags_of
from palpate.cli.output import Output, check_file
from palpate.core import PalpateError
from palpate.core.report import Column, Report

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from palpate.camera import Calibration

_FOLDER = "Folder of images of the board."
_BOARD = (
    "charuco, chessboard, circles or symmetric-circles, optionally with COLUMNSxROWS:SQUARE_MM[:MARKER_MM]: "
    "chessboard:9x6:25."
)
_OUT = "YAML file of the calibration, for OpenCV and ROS; without it, no file is written."
_PARAMETERS = ("parameter", "value", "standard deviation")
_IMAGES = ("image", Column("rms_px", "RMS residual", form=".3f", meaning="RMS distance of the board's points"))
_PRINT = "Write a PDF of the board in true size; FOLDER is then optional."


def calibrate(
    folder: Annotated[Path | None, Parameter(help=_FOLDER)] = None,
    *,
    board: Annotated[str, Parameter(help=_BOARD)] = "charuco",
    spec: Annotated[CalibrationSpec, flags_of(CalibrationSpec, without="board")] = CalibrationSpec(),
    out: Annotated[Path | None, Parameter(name=("--out", "-o"), help=_OUT)] = None,
    print_board: Annotated[Path | None, Parameter(help=_PRINT)] = None,
    output: Output = Output(),
) -> None:
    """Fit the focal length, centre and distortion of a camera to images of a board."""
    from palpate.camera import calibrate_camera, write_board, write_calibration

    chosen = read_board(board)
    check_file(print_board, ".pdf")
    check_file(out)
    if print_board is not None:
        write_board(print_board, chosen)
        print(
            f"Written to {print_board}. Print it at 100 % and measure a square: {chosen.square:g} mm.",
            file=sys.stderr,
        )
        if folder is None:
            return
    if folder is None:
        raise PalpateError(
            "No folder of images was given.", "Give FOLDER, or --print-board FILE.pdf.", code="argument-missing"
        )
    found = calibrate_camera(_read(folder), spec.model_copy(update={"board": chosen}))
    if out is not None:
        write_calibration(out, found)
    output.show(_describe(found), *_reports(found))


def _read(folder: Path) -> Iterator[tuple[str, NDArray[Any] | str]]:
    from palpate.camera import list_images, read_image

    for path in list_images(folder):
        try:
            yield path.name, read_image(path)
        except PalpateError as error:
            yield path.name, error.problem


def _describe(found: Calibration) -> dict[str, Any]:
    return {
        "model": found.model,
        "width_px": found.width_px,
        "height_px": found.height_px,
        "intrinsics_px": dict(zip(("fx", "fy", "cx", "cy"), found.intrinsics_px.tolist(), strict=True)),
        "distortion": found.distortion.tolist(),
        "sd": found.sd.tolist(),
        "rms_px": found.rms_px,
        "images": dict(zip(found.image_names, found.image_rms_px.tolist(), strict=True)),
        "rejected": dict(found.rejected),
        "note": found.note,
        "covered": found.covered,
        "coverage": found.coverage.tolist(),
    }


def _reports(found: Calibration) -> Iterator[Report | str]:
    names = ["fx px", "fy px", "cx px", "cy px", *found.lens.parameters()]
    values = [*found.intrinsics_px, *found.distortion]
    rows = [(name, f"{value:.5g}", f"{sd:.2g}") for name, value, sd in zip(names, values, found.sd, strict=True)]
    yield Report.of(f"{found.model} camera, {found.width_px} × {found.height_px} px", _PARAMETERS, rows)
    yield Report.of("images", _IMAGES, zip(found.image_names, map(float, found.image_rms_px), strict=True))
    for name, reason in found.rejected:
        yield f"left out: {name}: {reason}"
    if found.note:
        yield found.note
    yield f"RMS residual {found.rms_px:.4f} px; points in {found.covered:.0%} of the image's cells"
