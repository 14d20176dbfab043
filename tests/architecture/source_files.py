"""Source files of the package, each parsed once."""

import ast
from functools import cache
from pathlib import Path

SOURCE = Path(__file__).parents[2] / "src" / "palpate"
PLUGINS = tuple(sorted(door.parent for door in SOURCE.parents[1].glob("plugins/*/palpate_*/__init__.py")))
FILES = sorted(path for package in (SOURCE, *PLUGINS) for path in package.rglob("*.py"))


@cache
def tree(path: Path) -> ast.Module:
    """Syntax tree of a file."""
    return ast.parse(path.read_text())


@cache
def nodes(path: Path) -> tuple[ast.AST, ...]:
    """Every node of a file."""
    return tuple(ast.walk(tree(path)))


def name(path: Path) -> str:
    """Path of a file in the package, or in a plug-in beside it."""
    return path.relative_to(SOURCE if path.is_relative_to(SOURCE) else PLUGINS[0].parents[1]).as_posix()
