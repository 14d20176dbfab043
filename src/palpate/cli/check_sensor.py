"""`palpate sensor check`: check of the camera of a built sensor by its images."""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from palpate.camera import Source, open_source
from palpate.cli.accept import read_images
from palpate.cli.border import OUTSIDE
from palpate.cli.flag import flags_of
from palpate.cli.output import Output, check_folder
from palpate.core import PalpateError
from palpate.core.report import plain_page
from palpate.rig import CameraCheckSpec, TakeSpec
from palpate.vision import DetectSpec

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from palpate.rig import CameraFigure

    ImageOrError = NDArray[Any] | PalpateError

_SOURCE = (
    "Images of the unloaded skin: number of a camera or /dev/video0, a video, a folder, or the table of a recording "
    "(.csv) with its images of presses."
)
_PRESS = "Images while the skin is pressed: a folder or a video, or --source again for its images after rest."
_OUT = "Folder for the report: check.md, check.json and images.png."


@Parameter(name="*")
@dataclass(frozen=True)
class CameraCheckFlags:
    """Images of presses, and folder of the report."""

    press: Annotated[str | None, Parameter(help=_PRESS)] = None
    out: Annotated[Path | None, Parameter(name=("--out", "-o"), help=_OUT)] = None


def check(
    source: Annotated[str, Parameter(help=_SOURCE)],
    *,
    more: CameraCheckFlags = CameraCheckFlags(),
    spec: Annotated[CameraCheckSpec, flags_of(CameraCheckSpec, group="Images and limits")] = CameraCheckSpec(),
    detect: Annotated[DetectSpec, flags_of(DetectSpec, only="polarity diameter_px", group="Markers")] = DetectSpec(),
    output: Output = Output(),
) -> int:
    """Check whether a camera is set up well enough to measure: light, sharpness, noise, motion and rate.

    No setting of the camera is changed. The exit code is 1 if a figure is beyond its limit (`passed` in the JSON).
    """
    from palpate.rig import check_camera, find_automatic_controls
    from palpate.sensor import read_ground_truth

    check_folder(more.out)
    controls: list[CameraFigure] = []
    times: list[float] = []
    with ExitStack() as opened:
        rest: Iterable[ImageOrError]
        press: Iterable[ImageOrError] = ()
        if Path(source).suffix.lower() == ".csv":
            known = read_ground_truth(Path(source)).locate(Path(source).parent)
            rest = read_images(known.rest[: spec.rest_images])
            press = read_images(known.images[: spec.press_images])
        else:
            camera = opened.enter_context(open_source(source))
            images, controls = camera.images(), find_automatic_controls(camera)
            rest = _take(camera, images, spec.rest_images, times, spec.interval_s)
            if more.press == source:
                if camera.live:
                    print("Now press the skin slowly, and release it.", file=sys.stderr, flush=True)
                press = _take(camera, images, spec.press_images, [])
        if more.press not in (None, source):
            pressed = opened.enter_context(open_source(more.press or ""))
            press = _take(pressed, pressed.images(), spec.press_images, [])
        found = check_camera(rest, press, () if spec.interval_s else times, spec, detect)
    found = replace(found, figures=(*found.figures, *controls))
    if more.out is not None:
        found.write(more.out, source)
        print(f"Report: {more.out / 'check.md'}", file=sys.stderr)
    output.show({"source": source, **found.as_dict()}, *plain_page(found.page(source)))
    return OUTSIDE if found.findings else 0


def _take(
    source: Source, images: Iterator[ImageOrError], count: int, times: list[float], interval_s: float = 0.0
) -> Iterable[ImageOrError]:
    """Return the next images of a source, and add their times to `times`.

    A recording is read while they are used. Images of a live camera are taken at once, after those that it buffered,
    so that the check delays none.
    """

    def timed() -> Iterator[ImageOrError]:
        due = 0.0
        for image in images:
            if source.live:
                now = time.monotonic()
                if now < due:
                    continue
                due = now + interval_s
                times.append(now)
            else:
                times.extend(source.times[len(times) : len(times) + 1])
            yield image

    if not source.live:
        return islice(timed(), count)
    next(islice(images, TakeSpec().buffered - 1, None), None)
    return list(islice(timed(), count))
