"""One file writes CSV and draws tables in Markdown: `core/report.py`."""

import ast
import re
from collections.abc import Iterator

from source_files import FILES, SOURCE, name, nodes

REPORT = SOURCE / "core" / "report.py"
YAML = SOURCE / "camera" / "calibration_file.py"
RULE = re.compile(r"\| ?:?-{3,}|-{3,}:? ?\||^:?-{3,}:?$")
"""The line below the heading of a table in Markdown, or a cell of it."""


def csv_writers(found: tuple[ast.AST, ...]) -> Iterator[str]:
    """Names of `csv` that write, as they are called or imported."""
    for node in found:
        if isinstance(node, ast.Attribute) and ast.unparse(node.value) == "csv":
            yield node.attr
        if isinstance(node, ast.ImportFrom) and node.module == "csv":
            yield from (alias.name for alias in node.names)


def rules(found: tuple[ast.AST, ...]) -> Iterator[str]:
    """Texts of a program that draw the rule of a table; docstrings draw other things."""
    documents = [node.value for node in found if isinstance(node, ast.Expr)]
    for node in found:
        text = isinstance(node, ast.Constant) and isinstance(node.value, str) and node not in documents
        if text and RULE.search(node.value):
            yield node.value


def test_one_file_writes_csv() -> None:
    writing = {name(path) for path in FILES if {"writer", "DictWriter"} & set(csv_writers(nodes(path)))}
    assert writing == {name(REPORT)}


def test_one_file_draws_tables_in_markdown() -> None:
    drawn = {name(path): list(rules(nodes(path))) for path in FILES}
    assert {path for path, found in drawn.items() if found} - {name(YAML)} == {name(REPORT)}  # YAML begins with ---


def test_a_second_writer_would_be_found() -> None:
    planted = tuple(ast.walk(ast.parse("import csv\ncsv.DictWriter(file, names)\nlines = ['| a |', '|---|---|']")))
    assert list(csv_writers(planted)) == ["DictWriter"]
    assert list(rules(planted)) == ["|---|---|"]
