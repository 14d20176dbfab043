"""Numbers in tables of pages are those of the results files that the page names."""

import csv
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

DOCS = Path(__file__).parents[2] / "docs"
PAGES = [page for page in sorted(DOCS.rglob("*.md")) if DOCS / "reference" not in page.parents]
DECIMAL = re.compile(r"(?<![\w.])(\d+\.\d+)(?![\w.])( ?%)?")
ELSEWHERE = {
    "sensor.md": {
        "0.620": "of units before rounding; those of the file give 0.621",
        **dict.fromkeys(("1.62", "1.40"), "printed in the paper"),
    },
    "results/design_search/README.md": dict.fromkeys(
        ("0.0187", "0.081", "0.0188", "0.0217", "0.0192", "0.084"), "validation on the test bench"
    ),
    "results/benchmark/README.md": {"212.5": "size of the set, MB"},
    "results/robot/README.md": dict.fromkeys(("93.7", "94.7"), "share over the rows of the file"),
}
"""Page → number → its source, if it is in no file."""


def sections(page: Path) -> list[str]:
    """Sections of a page without code."""
    text = re.sub(r"^```.*?^```", "", page.read_text("utf-8"), flags=re.S | re.M)
    return re.split(r"^#+ ", text, flags=re.M)


def named_files(page: Path, text: str) -> list[Path]:
    """Results files to which a text links, else those in the folder of a page of results."""
    linked = [page.parent / link for link in re.findall(r"\(([^()\s]+\.csv)\)", text)]
    return linked or (sorted(page.parent.glob("*.csv")) if page.name == "README.md" else [])


@cache
def numbers(path: Path) -> tuple[float, ...]:
    """Magnitudes of all numbers in a file, and of a test bench the RMS over the units of each component."""
    found = {float(one) for one in re.findall(r"\d+\.?\d*(?:e[+-]?\d+)?", path.read_text("utf-8"))}
    with path.open(newline="", encoding="utf-8") as file:
        table = [row for row in csv.DictReader(file) if row.get("RMSE") and row.get("unit", "").isdigit()]
    for component in {row["component"] for row in table}:
        squares = [float(row["RMSE"]) ** 2 for row in table if row["component"] == component]
        found.add(float(np.sqrt(np.mean(squares))))
    return tuple(found)


def rows(page: Path) -> list[tuple[str, list[Path]]]:
    """Rows of tables, with the files that the row names, or its section."""
    found = []
    for section in sections(page):
        table = [line for line in section.splitlines() if line.startswith("|")][2:]
        found += [(row, named_files(page, row) or named_files(page, section)) for row in table]
    return [(row, paths) for row, paths in found if paths]


def unknown(row: str, paths: list[Path]) -> list[str]:
    """Decimal numbers of a row that are in none of the files, rounded as printed; percent may be shares there."""
    values = [value for path in paths for value in numbers(path)]
    missing = []
    for text, percent in DECIMAL.findall(row):
        half_digit = 0.501 * 10.0 ** -len(text.split(".")[1])
        scales = (1.0, 100.0) if percent else (1.0,)
        if not any(abs(float(text) - value * scale) <= half_digit for value in values for scale in scales):
            missing.append(text)
    return missing


PAGES_WITH_FILES = [page for page in PAGES if rows(page)]


@pytest.mark.parametrize("page", PAGES_WITH_FILES, ids=lambda page: str(page.relative_to(DOCS)))
def test_numbers_of_a_table_are_those_of_the_named_files(page: Path) -> None:
    missing = {text for row, paths in rows(page) for text in unknown(row, paths)}
    assert missing == set(ELSEWHERE.get(page.relative_to(DOCS).as_posix(), {}))


def test_changed_digits_are_found() -> None:
    """One changed digit in 30 % of cases, since files have many numbers: ten stale numbers are found in 97 %."""
    tried = found = 0
    for row, paths in (one for page in PAGES_WITH_FILES for one in rows(page)):
        for text, _ in DECIMAL.findall(row):
            digits = len(text.split(".")[1])
            changed = f"{float(text) + 3 * 10.0**-digits:.{digits}f}"
            tried, found = tried + 1, found + bool(unknown(f"| {changed} |", paths))
    assert found >= 0.29 * tried, (found, tried)
