"""Tests match codes and values of errors, never sentences, which are rewritten; one file tests the sentences."""

import ast
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
FOREIGN: dict[str, int] = {}
"""File → matches of errors that are not the package's own and have no code; their number may only fall."""


def matches(path: Path) -> Iterator[int]:
    """Lines of `pytest.raises` with a pattern."""
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if not isinstance(node, ast.Call) or ast.unparse(node.func) not in ("pytest.raises", "raises"):
            continue
        if any(word.arg == "match" for word in node.keywords):
            yield node.lineno


def test_no_test_matches_the_sentence_of_an_error() -> None:
    """`refused` of `tests/errors.py` matches its code and values."""
    files = [path for path in sorted(ROOT.rglob("test_*.py")) if path.name != "test_messages.py"]
    assert len(files) > 200
    found = Counter({str(path.relative_to(ROOT)): len(list(matches(path))) for path in files})
    assert +found == Counter(FOREIGN)
