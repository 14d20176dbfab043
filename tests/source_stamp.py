"""Hash of the source, by which stored results of tests are found again; imports nothing of the package."""

import ast
import hashlib
import os
import sys
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

SOURCE = Path(next(iter(find_spec("palpate").submodule_search_locations)))  # type: ignore[union-attr, arg-type]
LIBRARIES = ("numpy", "scipy", "numba", "py-mkl-pardiso", "rslab")
STAMP = "PALPATE_TEST_STAMP"
"""Variable of the environment by which workers take the hash from the process that starts them."""


def source_stamp() -> str:
    """Hash of the source and of the versions of the numeric libraries; once per run of pytest."""
    if STAMP not in os.environ:
        digest = hashlib.sha256(f"{sys.version}{[_version(name) for name in LIBRARIES]}".encode())
        for path in sorted(SOURCE.rglob("*.py")):
            digest.update(path.relative_to(SOURCE).as_posix().encode() + _syntax(path).encode())
        os.environ[STAMP] = digest.hexdigest()[:16]
    return os.environ[STAMP]


def _syntax(path: Path) -> str:
    """Syntax tree of a file without docstrings."""
    tree = ast.parse(path.read_bytes())
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            node.body = [part for part in body if not _is_text(part)]  # type: ignore[attr-defined]
    return ast.dump(tree)


def _is_text(node: ast.AST) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return ""
