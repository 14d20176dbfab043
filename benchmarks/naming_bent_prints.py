"""Assign the markers of drawn prints that are distorted as a whole, and refuse what is no print of the design.

    python benchmarks/naming_bent_prints.py --out docs/results/sensor/bent_prints.csv [--draws 500] [--images 25]

Rings that are distorted by any function within 15 % that keeps their order, and an ellipse of up to 8 % (half
of the prints take their markers along). Each ring is up to 2 px eccentric, and each marker is rotated by up to
0.5°. Any roll, a camera up to 6 mm off axis and tilted by 8°, with residual distortion. 5 % of the markers are
missing (the mark among them); 10 false blobs lie a marker diameter away from markers. Images have blur, noise,
uneven light and touching blobs. Half of the draws have an orientation mark.

* Whole: every index correct, or correct up to a symmetry and reported as ambiguous if no mark was printed.
* Ambiguous: the same although the mark was visible. Mark hidden: the same with a hidden mark.
* Lost: a visible marker is reported as missing. Refused: rejected with a reason.
* Stand-in (an additional count): a false blob within 0.18 of the spacing of an empty place is taken for its marker.
* Reprojection: RMS distance from the print without the scatter of single markers.
"""

from __future__ import annotations

import argparse
import csv
import sys
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))
sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "unit" / "vision"))
from bent_prints import DESIGNS, bent, controls, design_of, draw, judge

from palpate.core import PalpateError, generator
from palpate.vision import assign_markers, prepare_detector, register_dome

COUNTS = (7, 37, 91, 169)
SCALES = (1.0, 1.6)

VERDICTS = ("whole", "ambiguous", "mark hidden", "lost", "refused", "wrong", "stand-in")


@dataclass
class Row:
    """Figures of one number of markers."""

    verdicts: Counter[str] = field(default_factory=Counter)
    seconds: list[float] = field(default_factory=list)
    law_px: list[float] = field(default_factory=list)
    nominal_px: list[float] = field(default_factory=list)
    refused_pose: int = 0


def name_draws(count: int, draws: int, image: bool) -> Row:
    """Draw prints, half of them with an orientation mark, and name them."""
    row = Row()
    for number in range(draws):
        rng = generator(20, "bent print", count, number, image)
        scale, marked = SCALES[number // 2 % 2] if not image else SCALES[1], bool(number % 2)
        drawn = bent(count, rng, scale=scale, mark=marked, kept=number // 4 % 2 == 1)
        design = design_of(count, scale, marked)
        try:
            dots = drawn["dots"] if not image else _detected(drawn, rng)
            start = time.process_time()
            naming = assign_markers(dots, design.pattern)
            row.seconds.append(time.process_time() - start)
        except PalpateError as error:
            row.verdicts["refused"] += 1
            print(count, number, image, error, file=sys.stderr)
            continue
        found = judge(naming, drawn, dots, design)
        row.verdicts[found.verdict] += 1
        row.verdicts["stand-in"] += found.stand_ins > 0
        if found.verdict in ("wrong", "lost"):
            print(count, number, image, found[:4], file=sys.stderr)
        if found.verdict != "wrong" and number % 5 == 0 and not image:
            _register(found.naming, drawn, design, row)
    return row


def _detected(drawn: dict, rng: np.random.Generator) -> np.ndarray:
    picture = draw(drawn["dots"], drawn["shape"], rng, scale=SCALES[1])
    return prepare_detector(picture, doubt=False).find(picture).positions_px  # as a sensor opens


def _register(naming, drawn, design, row) -> None:
    try:
        found = register_dome(naming, design.layout, design.skin, design.camera)
    except PalpateError as error:
        row.refused_pose += 1
        print("pose:", error, file=sys.stderr)
        return
    for places, into in (
        (design.layout.positions if found.distortion is None else found.distortion.positions, row.law_px),
        (design.layout.positions, row.nominal_px),
    ):
        off = found.camera.project(places) - drawn["smooth"]
        into.append(float(np.sqrt(np.mean((off[naming.found] ** 2).sum(axis=1)))))


def name_controls(draws: int) -> list[tuple[str, int, int]]:
    """Return kind, number, and number assigned of inputs that are no print of the design."""
    rows = []
    for kind, make in controls().items():
        named = tried = 0
        for number in range(draws):
            for dots, pattern in make(generator(20, "control", kind, number)):
                tried += 1
                try:
                    assign_markers(dots, pattern)
                    named += 1
                    print("control named:", kind, number, len(pattern), file=sys.stderr)
                except PalpateError:
                    pass
        rows.append((kind, tried, named))
    return rows


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--draws", type=int, default=500)
    parser.add_argument("--images", type=int, default=25)
    parser.add_argument("--controls", type=int, default=6)
    given = parser.parse_args()
    rows: list[dict[str, object]] = []
    for source, draws in (("markers", given.draws), ("images", given.images)):
        for count in COUNTS:
            found = name_draws(count, draws, source == "images")
            ms, law = 1e3 * np.array(found.seconds), found.law_px
            rows.append(
                {"input": source, "design": count, "draws": draws}
                | {name.replace(" ", "_").replace("-", "_"): found.verdicts[name] for name in VERDICTS}
                | {"cpu_ms_median": f"{np.median(ms):.0f}", "cpu_ms_max": f"{ms.max():.0f}"}
                | {
                    f"ring_model_px_{name}": f"{np.percentile(law, q):.2f}"
                    for name, q in (("median", 50), ("p95", 95))
                    if law
                }
                | ({"design_px_median": f"{np.median(found.nominal_px):.2f}"} if law else {})
            )
    for kind, tried, named in name_controls(given.controls):
        rows.append({"input": "control", "design": kind, "draws": tried, "whole": named})
    with given.out.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


if __name__ == "__main__":
    assert set(COUNTS) <= set(DESIGNS)
    main()
