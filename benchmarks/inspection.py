"""Inspect rendered domes of the paper's grid whose dots were misprinted by known amounts; a table and a picture.

python benchmarks/inspection.py --out docs/results/sensor/inspection.csv --picture docs/images/inspection.png
"""

from __future__ import annotations

import argparse
import csv
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "unit" / "sensor"))
from test_inspect_unit import photograph, printed, unit_of

from palpate.core import generator
from palpate.sensor import draw_inspection, inspect_unit

SD = 0.08
"""Standard deviation of a misprint in each direction, mm."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--picture", type=Path, required=True)
    given = parser.parse_args()
    rows = []
    for height in (10, 20, 30):
        for count in (37, 91, 169):
            unit = unit_of(height, count)
            error = generator(0, "print").normal(0, SD, (count, 2))
            error[0] = 0.0
            inspection = inspect_unit([photograph(unit, printed(unit, error))], unit)
            left = (inspection.error - error)[1:]
            row = {"height_mm": height, "markers": count, "misprint_sd_mm": SD}
            row |= {"missing": len(inspection.missing), "rms_mm": float(np.sqrt((left**2).mean()))}
            row |= {"max_mm": float(np.abs(left).max()), "mm_per_px_max": float(inspection.mm_per_px.max())}
            rows.append({name: round(value, 4) for name, value in row.items()})
            print(rows[-1])
            if (height, count) == (20, 169):
                draw_inspection(inspection).savefig(given.picture, dpi=100)
    with given.out.open("w", newline="", encoding="utf-8") as file:
        table = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


if __name__ == "__main__":
    main()
