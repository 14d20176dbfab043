"""Hash of the source, by which stored results of tests are found again; imports nothing of the package."""

import ast
import hashlib
import json
import os
import sys
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

SOURCE = Path(next(iter(find_spec("palpate").submodule_search_locations)))  # type: ignore[union-attr, arg-type]
LIBRARIES = ("numpy", "scipy", "numba", "py-mkl-pardiso", "rslab")
PRESS = ("core", "design", "mesh", "material", "mechanics", "fea")
PARTS = {"press": PRESS, "twin": (*PRESS, "surrogate")}
"""Kind of a result → subpackages that decide it; the whole source if the kind is not named."""
READ = (".py", ".yaml", ".csv", ".json")
"""Endings of files that decide a result; of those of `PARTS`, only Python files, since inputs name the others."""
STAMPS = "PALPATE_TEST_STAMPS"
"""Variable of the environment by which workers take the hashes from the process that starts them."""


def source_stamp(kind: str) -> str:
    """Hash of the source that decides a kind of result, and of the versions of the numeric libraries."""
    if STAMPS not in os.environ:
        files = {
            path.relative_to(SOURCE): _content(path) for path in sorted(SOURCE.rglob("*")) if path.suffix in READ
        }
        os.environ[STAMPS] = json.dumps({kind: _hash(files, kind) for kind in (*PARTS, "")})
    stamps: dict[str, str] = json.loads(os.environ[STAMPS])
    return stamps.get(kind, stamps[""])


def _hash(files: dict[Path, str], kind: str) -> str:
    digest = hashlib.sha256(f"{sys.version}{[_version(name) for name in LIBRARIES]}".encode())
    for path, syntax in files.items():
        if kind not in PARTS or (path.parts[0] in PARTS[kind] and path.suffix == ".py"):
            digest.update(f"{path.as_posix()} {syntax}".encode())
    return digest.hexdigest()[:16]


def _content(path: Path) -> str:
    """Syntax tree of a Python file without docstrings; the text of another file."""
    if path.suffix != ".py":
        return path.read_text("utf-8")
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
