"""The words of the field in docstrings, messages, pages and names: counts in `words.csv` that may only fall.

Exceptions are the rows of `words_allowed.csv`: a pattern is not counted in the file, or below the folder, of its row.

A row that is too high after a change is set to the new count: `python tests/architecture/test_words.py` rewrites the
table with the counts of today wherever they are lower, and never raises one.
"""

import ast
import csv
import re
import sys
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from source_files import FILES, nodes, tree

ROOT = Path(__file__).parents[2]
TABLE = Path(__file__).with_name("words.csv")
EXCEPTIONS = Path(__file__).with_name("words_allowed.csv")
GENERATED = ROOT / "docs" / "reference"
WRITTEN = (path for path in sorted((ROOT / "docs").rglob("*.md")) if GENERATED not in path.parents)
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *WRITTEN]
DIALECT = {"told", "tell", "say", "said", "foresee", "foreseen", "learnt", "teach", "taught", "judge", "judged"}
DIALECT |= {"play", "played", "belief", "kept", "beside", "slip", "slips", "off", "bend"}
"""Parts of names that belong to no field."""
ALLOWED = {"no_slip", "NO_SLIP", "call_off"}
"""Names with such a part that are the field's own."""
CLAUSE = r"^(What|How|Where|Who|Which|Why|Whose)\b"
PREPOSITION = r"^(From|Of|As|By|Into|Between|The same)\b"
Documented = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


@cache
def docstrings() -> tuple[tuple[str, str], ...]:
    """Paths and docstrings of modules, classes and functions, and the strings that document an attribute."""
    return tuple((_place(path), value.value) for path in FILES for value in _docstring_nodes(path))


def _place(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def _docstring_nodes(path: Path) -> Iterator[ast.Constant]:
    for node in nodes(path):
        if not isinstance(node, Documented):
            continue
        for number, child in enumerate(node.body):
            if (
                isinstance(child, ast.Expr)
                and isinstance(child.value, ast.Constant)
                and isinstance(child.value.value, str)
            ):
                before = node.body[number - 1]
                if number == 0 or isinstance(before, ast.Assign | ast.AnnAssign):
                    yield child.value


@cache
def messages() -> tuple[tuple[str, str], ...]:
    """Paths and all other strings of the source with a space, f-strings without their values."""
    found = []
    for path in FILES:
        documented = {id(value) for value in _docstring_nodes(path)}
        for node in nodes(path):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in documented:
                found.append((_place(path), node.value))
    return tuple((place, text) for place, text in found if " " in text.strip())


@cache
def pages() -> tuple[tuple[str, str], ...]:
    """Paths and texts of pages without code."""
    return tuple(
        (_place(path), re.sub(r"^```.*?^```", "", path.read_text("utf-8"), flags=re.S | re.M)) for path in PAGES
    )


def sentences() -> Iterator[str]:
    """Sentences of pages, without headings, tables and indented code."""
    for _, page in pages():
        lines = [line for line in page.splitlines() if not line.startswith(("#", "|", "    "))]
        for part in re.split(r"\n\s*\n|\n\s*(?:[*-]|\d+\.) ", "\n".join(lines)):
            yield from (one for one in re.split(r"(?<=[.!?:])\s+", part.strip()) if one)


def names() -> Counter[str]:
    """Names that are defined in the source and have a part of the dialect."""
    found: Counter[str] = Counter()
    for path in FILES:
        for node in nodes(path):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
                found[node.name] += 1
            elif isinstance(node, ast.arg):
                found[node.arg] += 1
            elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
                found[node.target.id] += 1
        for node in tree(path).body:
            if isinstance(node, ast.Assign):
                found.update(target.id for target in node.targets if isinstance(target, ast.Name))
    return Counter({name: count for name, count in found.items() if _parts(name) & DIALECT and name not in ALLOWED})


def _parts(name: str) -> set[str]:
    return {part.lower() for part in re.findall(r"[A-Z]?[a-z0-9]+|[A-Z]+", name)}


def structure() -> dict[str, int]:
    """Counts of forms."""
    first = [text.strip().splitlines()[0] if text.strip() else "" for _, text in docstrings()]
    increments = [path for path in FILES if path.parent.name in ("fea", "mechanics", "deck")]
    texts = [value.value for path in increments for value in _docstring_nodes(path)]
    decisions = sorted((ROOT / "docs" / "decisions").glob("[0-9]*.md"))
    return {
        "docstrings that begin with a clause": sum(bool(re.search(CLAUSE, line)) for line in first),
        "docstrings that begin with a preposition": sum(bool(re.search(PREPOSITION, line)) for line in first),
        "first lines longer than 100 characters": sum(len(line) > 100 for line in first),
        "sentences of pages longer than 30 words": sum(len(one.split()) > 30 for one in sentences()),
        "images where increments are meant": sum(
            len(re.findall(r"(?<!mirror )\b[Ii]mages?\b", text)) for text in texts
        ),
        "decisions without a status": sum("Status:" not in path.read_text("utf-8") for path in decisions),
    }


@cache
def counts() -> dict[tuple[str, str], int]:
    """Counts of today by kind and pattern."""
    found: dict[tuple[str, str], int] = {}
    allowed: dict[str, list[str]] = {}
    for row in read(EXCEPTIONS):
        allowed.setdefault(row["pattern"], []).append(row["path"])
    for row in rows():
        if row["kind"] in ("docstrings", "messages", "pages"):
            texts = {"docstrings": docstrings, "messages": messages, "pages": pages}[row["kind"]]()
            pattern = re.compile(row["pattern"], re.IGNORECASE)
            places = tuple(allowed.get(row["pattern"], ()))
            found[row["kind"], row["pattern"]] = sum(
                len(pattern.findall(text)) for place, text in texts if not place.startswith(places)
            )
    found |= {("structure", name): count for name, count in structure().items()}
    return found | {("name", name): count for name, count in names().items()}


def rows() -> list[dict[str, str]]:
    """The table: kind, pattern, count at most, and what is written instead or why it stays."""
    return read(TABLE)


def read(path: Path) -> list[dict[str, str]]:
    """Rows of a table."""
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize("kind", ["docstrings", "messages", "pages", "structure", "name"])
def test_no_count_rises(kind: str) -> None:
    allowed = {(row["kind"], row["pattern"]): int(row["count"]) for row in rows()}
    found = {key: count for key, count in counts().items() if key[0] == kind}
    assert {key[1]: (count, allowed.get(key, 0)) for key, count in found.items() if count > allowed.get(key, 0)} == {}


def test_each_exception_is_needed() -> None:
    texts = (*docstrings(), *messages(), *pages())
    for row in read(EXCEPTIONS):
        pattern = re.compile(row["pattern"], re.IGNORECASE)
        assert any(pattern.search(text) for place, text in texts if place.startswith(row["path"])), row


def main() -> None:
    """Lower the counts of the table to those of today; names that are gone leave it."""
    found, kept = counts(), []
    for row in rows():
        count = min(int(row["count"]), found.get((row["kind"], row["pattern"]), 0))
        if count or row["kind"] != "name":
            kept.append({**row, "count": str(count)})
    with TABLE.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, ["kind", "pattern", "count", "write"], lineterminator="\n")
        writer.writeheader()
        writer.writerows(kept)


if __name__ == "__main__":
    sys.exit(main())
