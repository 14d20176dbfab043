"""Tables cut no number and no name at any width, and keep their values in every form."""

import csv
import io
import math
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from palpate.core.report import (
    EMPTY,
    Column,
    CsvWriter,
    Report,
    csv_text,
    page_markdown,
    plain_page,
    report_html,
    report_markdown,
    report_text,
    wrapped,
    write_csv,
)

WIDTHS = (20, 40, 80, 100, 120, None)
NAMES = st.text("abcdefghij_-0123456789", min_size=1, max_size=30)
VALUES = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(-(10**9), 10**9),
    st.floats(-1e6, 1e6),
    st.sampled_from([math.nan, math.inf, -math.inf]),
    NAMES,
    st.lists(st.integers(0, 99), max_size=3),
)
SENTENCES = st.lists(NAMES, min_size=1, max_size=12).map(" ".join)


@st.composite
def reports(draw: st.DrawFn) -> Report:
    """Tables of up to ten columns, some with sentences, some that are not needed first."""
    columns = [
        Column(
            f"{draw(NAMES)}{number}{draw(st.sampled_from(['', '_mm', '_deg', '_n']))}",
            heading=draw(st.one_of(st.just(""), SENTENCES)),
            meaning=draw(st.one_of(st.just(""), SENTENCES)),
            deciding=draw(st.booleans()),
            prose=draw(st.booleans()),
        )
        for number in range(draw(st.integers(1, 10)))
    ]
    cells = {one.name: SENTENCES if one.prose else VALUES for one in columns}
    rows = draw(st.lists(st.fixed_dictionaries(cells), max_size=4))
    return Report(draw(st.one_of(st.just(""), SENTENCES)), columns, rows, draw(st.lists(SENTENCES, max_size=2)))


def check_width(text: str, width: int | None) -> None:
    """No line is longer than the width unless it is one word, with its indentation and the name of its column."""
    for line in text.split("\n"):
        assert line == line.rstrip()
        assert width is None or len(line) <= width or len(line.split()) == 1, line


def words_of(text: str) -> str:
    """A text without line ends and gaps."""
    return " ".join(text.split())


@settings(max_examples=60, deadline=None)
@given(reports(), st.sampled_from(WIDTHS), st.booleans())
def test_no_value_is_cut_and_no_line_is_too_long(report: Report, width: int | None, wide: bool) -> None:
    text = report_text(report, width, wide=wide)
    check_width(text, width)
    words = set(text.split())
    for column in report.columns:
        if column.deciding or wide or width is None:
            for row in report.rows:
                assert set(column.text(row[column.name]).split()) - {EMPTY} <= words


@settings(max_examples=30, deadline=None)
@given(reports(), st.sampled_from(WIDTHS))
def test_columns_that_are_left_out_are_counted(report: Report, width: int | None) -> None:
    filled = [one for one in report.columns if any(one.text(row[one.name]) != EMPTY for row in report.rows)]
    text = words_of(report_text(report, width))
    least = 0 if width is None else len([one for one in filled if not one.deciding])
    said = [int(part.split()[-1]) for part in text.split(" more column")[:-1]]
    assert len(said) <= 1
    assert 0 <= (said[0] if said else 0) <= least


FORCES = Report(
    "presses",
    [
        Column("name"),
        Column("depth_mm", form=".2f", meaning="depth of the wall"),
        Column("force_n", "contact force", form=".4f"),
        Column("work_mj", form=".3f", deciding=False),
        Column("note", prose=True, deciding=False),
    ],
    [
        {"name": "first", "depth_mm": 0.4, "force_n": 0.0200, "work_mj": 1.25, "note": "a long sentence, " * 4},
        {"name": "second_of_all", "depth_mm": 12.0, "force_n": -0.3, "work_mj": 2.5},
    ],
    ["Two presses."],
    "force.csv",
)


def test_a_narrow_table_keeps_the_deciding_columns_and_counts_the_rest() -> None:
    assert report_text(FORCES, 38).split("\n") == [
        "presses",
        "                      contact",
        "name           depth    force   work",
        "                  mm        N     mJ",
        "─────────────  ─────  ───────  ─────",
        "first           0.40   0.0200  1.250",
        "second_of_all  12.00  -0.3000  2.500",
        "1 more column: --wide, --json,",
        "force.csv",
        "Two presses.",
    ]


def test_below_the_width_of_the_deciding_columns_each_row_is_a_block() -> None:
    assert report_text(FORCES, 28).split("\n")[:4] == [
        "presses",
        "name             first",
        "  depth          0.40 mm",
        "  contact force  0.0200 N",
    ]


def test_wide_shows_all_columns_and_their_meaning() -> None:
    text = report_text(FORCES, 120, wide=True)
    assert "more column" not in text
    assert "\ndepth: depth of the wall\n" in text
    assert "1.250" in text


def test_a_pipe_gets_all_columns_in_lines_of_any_length() -> None:
    lines = report_text(FORCES, None).split("\n")
    assert ("a long sentence, " * 4).strip() in lines[5]
    assert "more column" not in "\n".join(lines)


def test_an_empty_table_says_so() -> None:
    assert report_text(Report("grid", FORCES.columns, []), 80) == "grid\nNo rows."


@pytest.mark.parametrize(
    ("value", "form", "text"),
    [
        (None, "", EMPTY),
        ("", "", EMPTY),
        (math.nan, ".3f", EMPTY),
        (math.inf, ".3f", "∞"),
        (-math.inf, "", "-∞"),
        (True, ".3f", "yes"),
        (False, "", "no"),
        (3, "", "3"),
        (3.0, "", "3"),
        (0.12345, "", "0.123"),
        (0.12345, ".1%", "12.3%"),
        (123456789012, "", "123456789012"),
        ([1, 2.5], "", "1, 2.500"),
        ([], "", EMPTY),
        ("first | second", "", "first | second"),
    ],
)
def test_values_read_as_people_write_them(value: object, form: str, text: str) -> None:
    assert Column("x", form=form).text(value) == text


@pytest.mark.parametrize(
    ("column", "label"),
    [
        (Column("travel_mm"), "travel (mm)"),
        (Column("rmse_deg"), "RMSE (°)"),
        (Column("n"), "n"),
        (Column("markers"), "markers"),
        (Column("stress_mpa", "peak stress"), "peak stress (MPa)"),
        (Column("area_mm2", "area", "mm²"), "area (mm²)"),
        (Column("ratio_mm", unit=""), "ratio mm"),
    ],
)
def test_headings_come_from_the_name_and_its_unit(column: Column, label: str) -> None:
    assert column.label == label


def test_markdown_aligns_numbers_and_escapes_bars() -> None:
    page = report_markdown(Report.of("", ("a|b", "size"), [("x|y\nz", 1.5), ("w", None)]))
    assert page == "| a\\|b | size |\n| :--- | ---: |\n| x\\|y z | 1.500 |\n| w | – |\n"


def test_html_escapes() -> None:
    page = report_html(Report.of("", ("<a>",), [("<script>&",)]))
    assert page == "<table><tr><th>&lt;a&gt;</th></tr><tr><td>&lt;script&gt;&amp;</td></tr></table>"


def test_a_page_in_markdown_is_printed_without_its_marks() -> None:
    table = Report.of("", ("a",), [(1,)])
    parts = ["# Title", "**passed**", table, "", "![errors](errors.png)", "the end"]
    marks = page_markdown(parts)
    assert marks == "# Title\n\n**passed**\n\n| a |\n| ---: |\n| 1 |\n\n![errors](errors.png)\n\nthe end\n"
    assert list(plain_page(parts)) == ["Title\n\npassed", table, "the end"]


ROWS = [{"name": 'say "a", b', "size_mm": 0.1, "none": None}, {"name": "two\nlines", "size_mm": 3, "none": ""}]


def test_csv_is_read_back() -> None:
    read = list(csv.DictReader(io.StringIO(csv_text(ROWS))))
    assert [row["name"] for row in read] == [row["name"] for row in ROWS]
    assert [float(row["size_mm"]) for row in read] == [0.1, 3.0]
    assert {row["none"] for row in read} == {""}
    assert csv_text([]) == ""


def test_a_csv_file_has_the_columns_that_were_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "table.csv"
    write_csv(path, iter([{"a": 1, "c": 3, "d": 4}, {"b": 2}]), ["a", "b", "c"])
    assert path.read_bytes() == b"a,b,c\n1,,3\n,2,\n"
    write_csv(path, [(1, 2.5), (3, None)], ["a", "b"])
    assert path.read_bytes() == b"a,b\n1,2.5\n3,\n"


def test_csv_is_written_row_by_row() -> None:
    file = io.StringIO()
    table = CsvWriter(file, ["a", "b"])
    assert file.getvalue() == "a,b\n"
    table.write({"b": 1})
    assert file.getvalue() == "a,b\n,1\n"


def test_lines_break_at_spaces_alone() -> None:
    text = "see results/first/a_very_long_name.csv or -x"
    assert wrapped(text, 16, "  ") == ["see", "  results/first/a_very_long_name.csv", "  or -x"]
    assert wrapped("a\n\nb", None) == ["a", "", "b"]
    assert wrapped("a\n\nb", 10) == ["a", "", "b"]
