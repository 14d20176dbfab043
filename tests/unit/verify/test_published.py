from pathlib import Path

import numpy as np
import pytest

from errors import refused
from palpate.verify import CASES, PUBLISHED, published_pages
from palpate.verify.curves import away_from, highest, turns
from palpate.verify.shallow import threshold

DOCS = Path(__file__).parents[3] / "docs"


def test_pages_name_cases_of_the_suite_and_say_all_there_is_to_say() -> None:
    names = {case.name for case in CASES}
    for item in PUBLISHED:
        assert set(item.cases) <= names
        assert all(len(text) > 20 for text in (item.source, item.read, item.ours, item.control, item.missing))


def test_pages_of_the_documentation_are_those_of_the_suites_page() -> None:
    pages = published_pages((DOCS / "verification.md").read_text(encoding="utf-8"))
    for name, page in pages.items():
        assert (DOCS / "published" / f"{name}.md").read_text(encoding="utf-8") == page
    index = (DOCS / "published" / "index.md").read_text(encoding="utf-8")
    assert [line for line in index.splitlines() if line in pages] == list(pages)


def test_a_row_outside_its_tolerance_shows_in_the_verdict() -> None:
    suite = (DOCS / "verification.md").read_text(encoding="utf-8")
    spoilt = "\n".join(
        line.replace("| yes |", "| **no** |") if line.startswith("| sphere_point |") else line
        for line in suite.splitlines()
    )
    assert published_pages(spoilt)["sphere_point"] != published_pages(suite)["sphere_point"]
    assert published_pages(spoilt)["sphere_point"].count("2 of 2") == 1


def test_a_page_without_rows_is_refused() -> None:
    with refused("case-row-missing", "clamped_cap_ring"):
        published_pages("# Verification\n")


def test_limit_points_of_a_cubic_are_found_between_its_points() -> None:
    w = np.linspace(0.0, 3.0, 41)
    upper, lower = turns(np.column_stack([w, w * (w - 1.5) * (w - 2.5) + w]))
    exact = np.polynomial.Polynomial([0.0, 4.75, -4.0, 1.0])
    assert (upper, lower) == pytest.approx(tuple(exact(np.sort(exact.deriv().roots().real))), abs=1e-3)
    assert highest(np.array([0.0, 1.0, 0.0])) == 1.0


def test_points_are_measured_from_the_line_and_not_from_its_points() -> None:
    assert away_from(np.array([[0.0, 0.0], [4.0, 2.0]]), np.array([[2.0, 1.0], [4.0, 2.0]])) == pytest.approx(
        0, abs=0.01
    )


def test_the_threshold_of_shallow_theory_grows_with_poissons_ratio() -> None:
    low, high = threshold(0.0), threshold(0.5)
    assert 5.0 < low < high < 6.0
