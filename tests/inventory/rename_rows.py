"""Account for the rows of a table of renames: applied, changed, deferred or skipped, by what the source defines.

    python tests/inventory/rename_rows.py RENAMES.csv

The table has the columns kind, old, new and where. A row is applied if the new name is defined in its place and the
old one is not; flags, keys and columns are looked up in their tables of old names. Rows of `changed_rows.csv` have
another new name, or none, for the reason given there. Modules, subpackages and verbs are renamed when they are moved;
a module that has its new name is applied.
Prints every row that is not applied, and the four counts; ends with 1 if a row is skipped.
"""

import ast
import csv
import sys
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from palpate.core.renamed_keys import RENAMED_COLUMNS, RENAMED_KEYS

ROOT = Path(__file__).parents[2]
CHANGED = Path(__file__).with_name("changed_rows.csv")
FLAGS = Path(__file__).with_name("renames.csv")
DEFERRED = {"module", "room", "verb"}
Row = dict[str, str]
Function = ast.FunctionDef | ast.AsyncFunctionDef


def read(path: Path) -> list[Row]:
    """Rows of a table."""
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def classify(rows: list[Row]) -> Iterator[tuple[str, Row, str]]:
    """Status, row and reason of each row."""
    changed = {(row["kind"], row["old"], row["where"]): row for row in read(CHANGED)}
    names = {row["old"]: row["new"] for row in rows if row["kind"] in ("class", "function", "method")}
    for row in rows:
        other = changed.get((row["kind"], row["old"], row["where"]))
        if other:
            done = applied(row | {"new": other["new"]}, names) if other["new"] else gone(row, names)
            yield "changed" if done else "skipped", row, f"{other['new'] or '(none)'}: {other['reason']}"
        elif row["kind"] in DEFERRED and not moved(row):
            yield "deferred", row, f"{row['kind']}, renamed when it is moved"
        else:
            yield "applied" if row["kind"] in DEFERRED or applied(row, names) else "skipped", row, ""


def moved(row: Row) -> bool:
    """Whether a module has its new name, in whatever subpackage."""
    found = (ROOT / "src").rglob(f"{row['new']}.py")
    return row["kind"] == "module" and not (ROOT / row["where"]).exists() and any(found)


def applied(row: Row, names: dict[str, str]) -> bool:
    """Whether the source has the new name of a row and not the old one."""
    kind, (*owner, old), new = row["kind"], row["old"].split("."), row["new"].split(".")[-1]
    if kind == "column":
        return RENAMED_COLUMNS.get(old) == new
    if kind == "key":
        return any(keys.get(old) == new for keys in RENAMED_KEYS.values())
    if kind == "flag":
        pairs = [
            (one["old"].split()[-1], one["new"].split()[-1])
            for one in read(FLAGS)
            if one["kind"] == "flag" and one["new"]
        ]
        return (old, new) in pairs
    owner = owner_now(owner, names)
    home = ROOT / row["where"]
    places = [scope for scope in scopes(home, tuple(owner)) if new in scope or old in scope] if home.exists() else []
    if not places:  # moved to another file
        paths = sorted((ROOT / "src").rglob("*.py"))
        places = [scope for path in paths for scope in scopes(path, tuple(owner)) if new in scope]
    return bool(places) and all(new in scope and old not in scope for scope in places)


def gone(row: Row, names: dict[str, str]) -> bool:
    """Whether the source has the old name of a row no more."""
    *owner, old = row["old"].split(".")
    home = ROOT / row["where"]
    return not home.exists() or not any(old in scope for scope in scopes(home, tuple(owner_now(owner, names))))


def owner_now(owner: list[str], names: dict[str, str]) -> list[str]:
    """Names of the definitions around a name as they are now."""
    return [names.get(".".join(owner[: number + 1]), part) for number, part in enumerate(owner)]


@cache
def nodes(path: Path) -> tuple[ast.AST, ...]:
    """Every node of a file, the module first."""
    return tuple(ast.walk(ast.parse(path.read_text("utf-8"))))


@cache
def scopes(path: Path, owner: tuple[str, ...]) -> tuple[frozenset[str], ...]:
    """Names that each definition of an owner has: a module, a class or a function of a class or module."""
    found: list[ast.AST] = [nodes(path)[0]]
    for number, part in enumerate(owner):
        inside = (child for node in found for child in (ast.walk(node) if number else nodes(path)))
        found = [child for child in inside if isinstance(child, ast.ClassDef | Function) and child.name == part]
    return tuple(frozenset(members(node)) for node in found)


def members(node: ast.AST) -> Iterator[str]:
    """Parameters of a function, or names that a module or class defines."""
    if isinstance(node, Function):
        every = (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs, node.args.vararg, node.args.kwarg)
        yield from (one.arg for one in every if one)
        return
    for child in ast.walk(node) if isinstance(node, ast.Module) else node.body:
        if isinstance(child, ast.ClassDef | Function):
            yield child.name
        if isinstance(child, ast.Assign | ast.AnnAssign):
            targets = child.targets if isinstance(child, ast.Assign) else [child.target]
            yield from (name.id for target in targets for name in ast.walk(target) if isinstance(name, ast.Name))
        if isinstance(node, ast.ClassDef) and isinstance(child, Function):
            for inner in ast.walk(child):
                if isinstance(inner, ast.Attribute) and isinstance(inner.ctx, ast.Store):
                    yield inner.attr


def main(path: Path) -> int:
    """Print the rows that are not applied, and the counts."""
    found = list(classify(read(path)))
    for status, row, reason in found:
        if status != "applied":
            print(f"{status}: {row['kind']} {row['old']} -> {row['new']} ({row['where']}) {reason}".rstrip())
    counts = Counter(status for status, _, _ in found)
    print(", ".join(f"{counts[status]} {status}" for status in ("applied", "changed", "deferred", "skipped")))
    return 1 if counts["skipped"] else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
