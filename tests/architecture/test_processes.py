"""One file starts worker processes, one class receives progress."""

import ast
from collections.abc import Iterator

from source_files import FILES, name, nodes

RUNNERS = {"core/run.py", "core/worker_process.py"}
"""The pool, and the environment of its processes."""
LIBRARIES = {"multiprocessing", "concurrent", "joblib"}


def imported(found: tuple[ast.AST, ...]) -> Iterator[str]:
    """Top-level modules that a program imports."""
    for node in found:
        if isinstance(node, ast.Import):
            yield from (each.name.partition(".")[0] for each in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module.partition(".")[0]


def test_the_pool_alone_starts_worker_processes() -> None:
    assert {name(path) for path in FILES if LIBRARIES & set(imported(nodes(path)))} == RUNNERS


def test_progress_is_shown_by_one_class_and_sent_by_another() -> None:
    found = {
        (name(path), node.name)
        for path in FILES
        for node in nodes(path)
        if isinstance(node, ast.ClassDef) and "Progress" in {ast.unparse(base) for base in node.bases}
    }
    assert found == {("cli/progress.py", "TerminalProgress"), ("core/run.py", "_SentProgress")}
