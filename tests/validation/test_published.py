from pathlib import Path

import numpy as np
import pytest

from palpate.verify import run_cases
from palpate.verify.case import Case, compare
from validation.cases import PUBLISHED_CASES
from validation.curves import away_from, highest, turns
from validation.pages import PUBLISHED, published_pages, read_rows, verification_page, write_rows
from validation.shallow import threshold

DOCS = Path(__file__).parents[2] / "docs"
ROWS = read_rows(DOCS / "results" / "verification.csv")


def test_pages_name_cases_and_are_complete() -> None:
    assert {name for item in PUBLISHED for name in item.cases} <= {case.name for case in PUBLISHED_CASES}
    for item in PUBLISHED:
        assert all(len(text) > 20 for text in (item.source, item.read, item.ours, item.control, item.missing))


def test_pages_of_the_documentation_are_those_of_its_rows() -> None:
    assert (DOCS / "verification.md").read_text(encoding="utf-8") == verification_page(ROWS)
    pages = published_pages(ROWS)
    for name, page in pages.items():
        assert (DOCS / "published" / f"{name}.md").read_text(encoding="utf-8") == page
    index = (DOCS / "published" / "index.md").read_text(encoding="utf-8")
    assert [line for line in index.splitlines() if line in pages] == list(pages)


def test_a_row_outside_its_tolerance_shows_in_the_verdict() -> None:
    spoilt = [{**row, "pass": "NO"} if row["case"] == "sphere_point" else row for row in ROWS]
    assert published_pages(spoilt)["sphere_point"] != published_pages(ROWS)["sphere_point"]
    assert published_pages(spoilt)["sphere_point"].count("2 of 2") == 1
    assert [line[:15] for line in verification_page(spoilt).splitlines() if line.endswith("| NO |")] == [
        "| sphere_point "
    ]


def test_a_case_without_rows_is_refused() -> None:
    with pytest.raises(LookupError) as caught:
        published_pages([])
    assert "clamped_cap_ring" in str(caught.value)


def test_rows_are_written_as_they_are_read(tmp_path: Path) -> None:
    bad = Case("bad", "exact", lambda: [compare("force, N", 1.1, 1.0, 0.01, ["d = 1 mm"])])
    write_rows(tmp_path / "rows.csv", [*run_cases([bad])])
    [row] = read_rows(tmp_path / "rows.csv")
    assert (row["quantity"], row["deviation"], row["tolerance"], row["pass"]) == (
        "force, N at d = 1 mm",
        "10.00 %",
        "1.00 %",
        "NO",
    )


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
