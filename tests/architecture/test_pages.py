"""Pages on the design: status and length of decisions, length of design notes, and paths that exist."""

import ast
import os
import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from errors import check_values

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
MAX_DECISION_WORDS, MAX_NOTES_WORDS = 160, 12_000
"""Words of one decision with its title, and of all design notes."""


def test_every_decision_has_a_status_and_is_short() -> None:
    texts = {path.name: path.read_text("utf-8") for path in sorted((DOCS / "decisions").glob("[0-9]*.md"))}
    assert texts
    assert [name for name, text in texts.items() if not re.search(r"^Status: \w+", text, re.M)] == []
    assert {name: len(text.split()) for name, text in texts.items() if len(text.split()) > MAX_DECISION_WORDS} == {}


def test_design_notes_together_are_short() -> None:
    lengths = [len(path.read_text("utf-8").split()) for path in (DOCS / "design_notes").glob("*.md")]
    assert sum(lengths) <= MAX_NOTES_WORDS


def test_every_path_and_name_in_where_to_add_exists() -> None:
    page = (DOCS / "where_to_add.md").read_text("utf-8")
    paths = re.findall(r"`((?:src|tests)/[^`\s]+)`", page)
    assert len(paths) > 50
    assert [path for path in paths if not (ROOT / path).exists()] == []
    names = set(re.findall(r"`palpate\.([a-z_.]+)\.([A-Z]\w+)`", page))
    assert names
    assert [name for module, name in names if not hasattr(import_module(f"palpate.{module}"), name)] == []
    suites = set(re.findall(r"`(\w+Suite)`", page))
    assert suites == set(import_module("palpate.testing").__all__)


def test_an_example_that_lacks_a_package_is_named_and_one_that_fails_shows_its_error(tmp_path: Path) -> None:
    """`docs/conf.py` writes pages when it is imported, so its function is taken alone."""
    functions = ("_run_example", "_plain")
    body = ast.parse((DOCS / "conf.py").read_text("utf-8")).body
    parts: list[ast.stmt] = [part for part in body if isinstance(part, ast.FunctionDef) and part.name in functions]
    names: dict[str, Any] = {"HERE": DOCS, "Path": Path, "os": os, "re": re, "subprocess": subprocess}
    names |= {"sys": sys, "Any": Any}
    exec(compile(ast.Module(parts, []), "conf.py", "exec"), names)
    example = tmp_path / "ex99_none.py"
    example.write_text("import nowhere_to_be_found\n")
    assert "nowhere_to_be_found" in names["_run_example"](example, tmp_path)
    assert not (tmp_path / "ex99_none.txt").exists()
    example.write_text("raise ValueError('some 37')\n")
    with pytest.raises(RuntimeError) as caught:
        names["_run_example"](example, tmp_path)
    check_values(str(caught.value), 37)
    example.write_text("print(1 + 1)\n")
    assert names["_run_example"](example, tmp_path) == "2\n"
