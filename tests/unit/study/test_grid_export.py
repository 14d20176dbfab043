import csv
import sys

import pytest

from errors import refused
from needs import needs
from palpate.study import SpecificationGrid, evaluate_grid, export_grid, html_rows
from results import make_design

GRID = evaluate_grid([make_design(), make_design(markers=7, failure="stopped")])


def test_csv_holds_the_columns_that_decide_and_the_tables_beside(tmp_path):
    files = export_grid(tmp_path / "g.csv", GRID)
    names = ["g.csv", "g_by_depth.csv", "g_by_tilt.csv", "g_presses.csv"]
    assert [path.name for path in files] == names
    assert sorted(path.name for path in tmp_path.iterdir()) == names
    with (tmp_path / "g.csv").open(newline="") as file:
        columns = next(csv.reader(file))
    assert columns[:2] == ["name", "height_mm"]
    assert len(columns) <= 30


def test_markdown_is_a_table_for_people(tmp_path):
    export_grid(tmp_path / "g.md", GRID)
    head, rule, first, second = (tmp_path / "g.md").read_text().splitlines()
    assert head.startswith("| height (mm) | thickness (mm) | markers | angle RMSE with jitter (°) |")
    assert len({line.count("|") for line in (head, rule, first, second)}) == 1
    assert "–" in second


def test_parquet_keeps_kinds_units_and_empty_cells(tmp_path):
    parquet = needs("pyarrow.parquet")
    export_grid(tmp_path / "g.parquet", GRID)
    table = parquet.read_table(tmp_path / "g.parquet")
    assert tuple(table.column_names) == GRID.columns
    assert table.column("rmse_deg").to_pylist() == [row["rmse_deg"] for row in GRID.designs]
    assert table.schema.field("travel_mm").metadata[b"unit"] == b"mm"
    depths = parquet.read_table(tmp_path / "g_by_depth.parquet")
    assert depths.column("bound_deg").to_pylist() == [row["bound_deg"] for row in GRID.by_depth]
    kinds = [str(table.schema.field(name).type) for name in ("markers", "rmse_deg", "shape")]
    assert kinds == ["int64", "double", "string"]


def test_missing_pyarrow_is_named_and_nothing_is_written(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with refused("extra-missing", "pyarrow", ".[parquet]"):
        export_grid(tmp_path / "g.parquet", GRID)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["g.xlsx", "g", "csv"])
def test_another_ending_is_refused(tmp_path, name):
    with refused("file-ending-unknown", ".csv", ".parquet", ".md"):
        export_grid(tmp_path / name, GRID)


def test_a_folder_that_is_not_there_is_reported(tmp_path):
    with refused("file-unwritable"):
        export_grid(tmp_path / "nowhere" / "g.csv", GRID)


def test_a_grid_as_html_has_its_texts_escaped():
    rows = tuple(
        {"height_mm": height, "thickness_mm": 2.0, "markers": 7, "travel_mm": "<b>"} for height in (10.0, 20.0)
    )
    table = html_rows(SpecificationGrid(rows))
    assert table.count("<tr>") == 3
    assert "&lt;b&gt;" in table
