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
# palpate benchmark: pose from the dots of a domed tactile sensor

A soft dome with printed dots inside and a camera behind it is pressed by a flat wall. From where the dots are
in one image, or from the image itself, tell how the wall is tilted (rx, ry), how deep it is, and how hard it
presses.

## What it holds

{counts}
No unit and no press has images in two splits. Image numbers are in a random order over the whole set, so that
neither number nor place in a file tells anything. `train` is to learn from, `calibrate` to choose settings and
intervals by, `test` to be judged on once.

## Files

* `SPLIT.h5`: by design, `image` (n,) numbers rising, `unit` (n,), `markers_px` (n, dots, 2) columns and rows in
  px, NaN where a dot is not there; `rest_unit` (units,) and `rest_px` (units, dots, 2) of the untouched units.
* `SPLIT_pictures.zip`: rendered images as PNG, 8 bit grey: `SPLIT/IMAGE.png` and `SPLIT/rest_DESIGN_UNIT.png`.
* `spec.json`: what was chosen; `croissant.json`: metadata for machines; `SHA256SUMS`: checksums of all files.
* `hidden.csv` and `hidden_units.csv`: labels and units of the test, to be withheld by whoever runs a contest.

{tables}
## How it was made

By simulation alone; no real sensor was used. Finite-element presses of each design (material {material}; no
slip and finite friction; the skin's other stable state where it has one) are interpolated by a twin over tilt,
depth, friction and wall thickness. Each unit deviates from its design within a workshop's tolerances: wall
thickness, stiffness, place of the print and of every dot, missing dots, camera and lens. Walls are even over
the disc of tilts to {tilt:g}°, friction is even in 1/µ, depth even from {least:g} to {most:g} mm, in the other
state from where it stands; {inverted:.0%} of the presses are in that state, where there is one. Dots have a
normal noise of {noise:g} px. Pictures show the same dots with uneven light, reflections, blur, grain and dirt.

{off}

## What it is not for

* It tells nothing of an elastomer that creeps, of wear, of walls that are bent or drift while they press.
* A method that knows palpate's own twin has an advantage: the set is drawn from such a twin, though of another
  mesh and other frictions than the baseline that fits by one.
* Units are drawn within one workshop's tolerances; they are not a survey of workshops.
* There are no personal data in it.

## Rules

Read `rest_px`, or the picture at rest, of a unit freely: a real sensor has it as well. Do not learn from
`test`. A table of predictions has the columns `image`, `rx_deg`, `ry_deg`, `depth_mm`, and may have `force_n`
and half-widths of intervals of nine tenths (`half_rx_deg`, `half_ry_deg`, `half_depth_mm`, `half_force_n`), a
row for every image of the test, or for every one that has a picture. `palpate benchmark score PREDICTIONS --set
FOLDER` judges it.

Whoever has the seed can make the test's labels. For a contest the set is made with a seed of its own for the
test (`--hidden-seed`), which is in no file of it, and `hidden.csv` and `hidden_units.csv` are kept back.

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
        least=spec.min_depth,
        most=spec.depth,
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
        return "How far the twins differ from presses between theirs was not measured."
    told = ", ".join(f"{name} {value:.3f} mm" for name, value in known.items())
    return f"Presses between those of the twins differ from them, as root mean square, by: {told}."
