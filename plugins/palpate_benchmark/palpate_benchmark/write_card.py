"""Data card: contents of the data set, method, files and limits."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from palpate.core.report import Report, report_markdown
from palpate_benchmark.columns import TABLES
from palpate_benchmark.spec import SPLITS, BenchmarkSpec

CARD = "README.md"
_PAGE = """\
# palpate benchmark: pose from the markers of a domed tactile sensor

A flat wall presses a soft dome with printed markers inside and a camera behind it. The task: estimate the tilt of
the wall (rx, ry), the depth and the contact force from one image or from the marker positions in it.

## Contents

{counts}
Each unit and each press has images in one split only. Image numbers are in a random order over the whole set, so
neither a number nor a place in a file contains information. `train` is for training, `calibrate` for settings and
intervals, `test` for one evaluation at the end.

## Files

* `SPLIT.h5`: by design, `image` (n,) ascending numbers, `unit` (n,), `markers_px` (n, markers, 2) columns and rows
  in px, NaN for a missing marker; `rest_unit` (units,) and `rest_px` (units, markers, 2) of the unloaded units.
* `SPLIT_pictures.zip`: rendered images as PNG, 8 bit grey: `SPLIT/IMAGE.png` and `SPLIT/rest_DESIGN_UNIT.png`.
* `spec.json`: settings; `croissant.json`: metadata for machines; `SHA256SUMS`: checksums of all files.
* `hidden.csv` and `hidden_units.csv`: labels and units of the test; a contest does not publish them.

{tables}
## Method

All data are simulated; no real sensor was used. Finite-element presses of each design (material {material}; no
slip and finite friction; the inverted branch of a bistable skin) are interpolated by a twin over tilt, depth,
friction and thickness. Each unit deviates from its design within the tolerances of a workshop: thickness,
stiffness, position of the print and of each marker, missing markers, camera and lens. Tilts are uniform over the
disc up to {tilt:g}°, friction is uniform in 1/µ, depth uniform from {minimum:g} to {maximum:g} mm, on the inverted
branch from its first contact; {inverted:.0%} of the presses of a bistable skin are inverted. Markers have a normal
noise of {noise:g} px. Rendered images show the same markers with uneven light, reflections, blur, grain and dirt.

{off}

## Limits

* The set does not cover relaxation of the elastomer, wear, and walls that bend or move sideways.
* A method that contains palpate's own twin has an advantage: the set is sampled from such a twin, though of another
  mesh and other frictions than the baseline that fits a twin.
* Units are sampled within the tolerances of one workshop; they are not a survey of workshops.
* The set contains no personal data.

## Rules

`rest_px` and the rest image of a unit may always be used: a real sensor has them too. Do not train on `test`. A
table of predictions has the columns `image`, `rx_deg`, `ry_deg`, `depth_mm`, optionally `force_n` and half-widths
of 90 % intervals (`half_rx_deg`, `half_ry_deg`, `half_depth_mm`, `half_force_n`), with a row for each image of the
test, or for each that has a rendered image. `palpate benchmark score PREDICTIONS --set FOLDER` evaluates it.

The seed reproduces the labels of the test. A contest makes the set with a separate seed for the test
(`--hidden-seed`), which no file contains, and does not publish `hidden.csv` and `hidden_units.csv`.

Licence: {licence}. Published by {creator}, {url}.
"""


@dataclass(frozen=True)
class SetCounts:
    """Numbers of images and presses, and twin errors, of a data set.

    Attributes
    ----------
    images, pictures, presses
        Numbers by split.
    twin_error_mm
        RMS distance of each design's twin from presses that it does not contain, mm.
    """

    images: Mapping[str, int]
    pictures: Mapping[str, int]
    presses: Mapping[str, int]
    twin_error_mm: Mapping[str, float]


def write_card(folder: Path, spec: BenchmarkSpec, counts: SetCounts) -> None:
    """Write the card into the folder of the data set."""
    units = {"train": spec.train_units, "calibrate": spec.calibrate_units, "test": spec.test_units}
    rows = [
        (split, units[split], counts.presses[split], counts.images[split], counts.pictures[split]) for split in SPLITS
    ]
    head = ("split", "units of each design", "presses", "images", "rendered images")
    page = _PAGE.format(
        counts=report_markdown(Report.of("", head, rows)),
        tables="\n".join(_tables()),
        material=spec.material,
        tilt=spec.max_tilt_deg,
        minimum=spec.min_depth,
        maximum=spec.depth,
        inverted=spec.inverted_share,
        noise=spec.noise_px,
        off=_error_text(counts.twin_error_mm),
        licence=spec.licence,
        creator=spec.creator,
        url=spec.url,
    )
    (folder / CARD).write_text(page, encoding="utf-8")


def _tables() -> Iterator[str]:
    for name, columns in TABLES.items():
        rows = [(column.name, column.unit, column.meaning) for column in columns]
        yield from (f"### {name}", "", report_markdown(Report.of("", ("column", "unit", "meaning"), rows)))


def _error_text(twins: Mapping[str, float]) -> str:
    known = {name: value for name, value in twins.items() if value == value}
    if not known:
        return "The interpolation error of the twins was not measured."
    errors = ", ".join(f"{name} {value:.3f} mm" for name, value in known.items())
    return f"Interpolation error of the twins (RMS): {errors}."
