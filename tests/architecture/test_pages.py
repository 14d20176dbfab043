"""Pages on the design: status and length of decisions, length of design notes, and paths that exist."""

import re
from importlib import import_module
from pathlib import Path

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
