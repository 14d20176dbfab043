"""Report of the check of a camera: a page with its figures and pictures, and data."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from palpate.core import wrap_write_errors
from palpate.core.report import Report
from palpate.rig.check_camera import CameraCheck
from palpate.sensor import provenance_line, write_report

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PICTURE = "images.png"


def write_camera_check(folder: Path, check: CameraCheck, title: str) -> None:
    """Write ``check.json``, ``check.md`` and ``images.png`` into a folder.

    Raises
    ------
    PalpateError
        If they cannot be written.
    """
    write_report(folder, "check", {"source": title, **check.as_dict()}, camera_check_page(check, title))
    with wrap_write_errors(folder, "Choose another folder."):
        draw_camera_check(check).savefig(folder / _PICTURE, dpi=120)


def camera_check_page(check: CameraCheck, title: str) -> list[str | Report]:
    """Return the report: verdict, a sentence for each finding, and all figures with their limits."""
    verdict = f"findings: {', '.join(one.code for one in check.findings)}" if check.findings else "no finding"
    rows = [
        (one.code, f"{one.value:.3g}", one.limit_text, one.unit.strip("1"), "ok" if one.passed else "beyond")
        for one in check.figures
    ]
    return [
        f"# Camera check: {title}",
        f"**{verdict}**",
        *(one.sentence for one in check.findings),
        Report.of("", ("figure", "value", "limit", "unit", "result"), rows),
        f"Images at rest: {len(check.rest.exposures)}; of presses: {len(check.press.exposures)}.",
        f"![Image with markers, and series]({_PICTURE})",
        provenance_line(),
    ]


def draw_camera_check(check: CameraCheck) -> Figure:
    """Draw the last image at rest with its blobs, and light, blur and motion of the images at rest."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 6.0), layout="constrained")
    axes = figure.subplot_mosaic([["image", "light / mean"], ["image", "blur, px"], ["image", "motion, px"]])
    rest = check.rest
    if rest.last is not None:
        grey = rest.last if rest.last.ndim == 2 else rest.last.mean(axis=2)
        axes["image"].imshow(grey, cmap="gray", vmin=0.0, vmax=rest.top)
    axes["image"].set(title="last image at rest, with blobs", xticks=[], yticks=[])
    if rest.figures:
        axes["image"].plot(*rest.figures[-1].blobs.positions_px.T, "+", color="#d1622b", ms=4)
        axes["light / mean"].plot(rest.brightness, ".-")
        axes["blur, px"].plot(rest.edge_px, ".-")
        axes["motion, px"].plot(rest.motion[0], ".-", label=("column", "row", "rotation", "scale"))
        axes["motion, px"].legend(fontsize=8)
    for name, axis in axes.items():
        axis.set_ylabel("" if name == "image" else name)
    return figure
