"""Name the dots of drawn prints that are bent as a whole, and refuse what is no print of the design; a page.

python benchmarks/naming_bent_prints.py --out docs/results/sensor/naming_bent_prints.md [--draws 500] [--images 25]
"""

from __future__ import annotations

import argparse
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


LEGEND = """\
Rings that are distorted by any function within 15 % that keeps their order, and an ellipse of up to 8 % (half
of the prints take their markers along). Each ring is up to 2 px eccentric, and each marker is rotated by up to
0.5°. Any roll, a camera up to 6 mm off axis and tilted by 8°, with residual distortion. 5 % of the markers are
missing (the mark among them); 10 false blobs lie a marker diameter away from markers. Images have blur, noise,
uneven light and touching blobs. Half of the draws have an orientation mark.

* Whole: every index correct, or correct up to a symmetry and reported as ambiguous if no mark was printed.
* Ambiguous: the same although the mark was visible. Mark hidden: the same with a hidden mark.
* Lost: a visible marker is reported as missing. Refused: rejected with a reason.
* Stand-in (an additional count): a false blob within 0.18 of the spacing of an empty place is taken for its marker.
* Reprojection: RMS distance from the print without the scatter of single markers."""


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
    """What must not be named: kind, how many, how many were named without a word."""
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
    command = (__doc__ or "").split("\n\n")[1].strip()
    lines = ["# Assignment of distorted prints", "", f"    {command}", "", LEGEND, ""]
    names = ("whole", "ambiguous", "mark hidden", "lost", "refused", "wrong", "stand-in")
    for image, draws in ((False, given.draws), (True, given.images)):
        heading = "Full images through the detector" if image else "Marker positions"
        lines += [f"## {heading}", "", f"| markers | draws | {' | '.join(names)} | CPU ms, median | most |"]
        lines += ["| --- " * (len(names) + 4) + "|"]
        rows = {count: name_draws(count, draws, image) for count in COUNTS}
        for count, row in rows.items():
            ms = 1e3 * np.array(row.seconds)
            cells = [str(row.verdicts[name]) for name in names]
            lines.append(f"| {count} | {draws} | {' | '.join(cells)} | {np.median(ms):.0f} | {ms.max():.0f} |")
        lines.append("")
        if not image:
            lines += [
                "## Reprojection at rest, px",
                "",
                "| markers | prints | ring model, median | 95 % | design alone, median | refused |",
            ]
            lines += ["| --- " * 6 + "|"]
            for count, row in rows.items():
                law = np.percentile(row.law_px, [50, 95])
                lines.append(
                    f"| {count} | {len(row.law_px)} | {law[0]:.2f} | {law[1]:.2f} | {np.median(row.nominal_px):.2f} "
                    f"| {row.refused_pose} |"
                )
            lines.append("")
    lines += ["## Controls", "", "| input | draws | assigned |", "| --- | --- | --- |"]
    lines += [f"| {kind} | {tried} | {named} |" for kind, tried, named in name_controls(given.controls)]
    given.out.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    assert set(COUNTS) <= set(DESIGNS)
    main()
