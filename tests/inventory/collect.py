"""Names of everything that users see, printed as JSON by the Python that has the package: python collect.py ROOT.

ROOT is the checkout, for studies, examples and extras. Only the standard library and the package are imported, so
that the program runs with an old wheel and with the new source.
"""

import importlib
import json
import sys
import tomllib
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import palpate
from palpate.cli.app import app

PLUGINS = () if find_spec("palpate.claims") else ("palpate_zaid2024", "palpate_benchmark")
"""Packages with names that were in `palpate` at the tag `before-restructure`."""


def verbs(part: Any = app, words: tuple[str, ...] = ()) -> Iterator[tuple[str, list[str]]]:
    """Every verb as it is typed, with its flags."""
    for name in part:
        if name.startswith("-") or not part[name].show:
            continue
        if part[name].default_command is None:
            yield from verbs(part[name], (*words, name))
        else:
            arguments = [one for one in part[name].assemble_argument_collection() if one.parse and not one.children]
            flags = [flag for one in arguments for flag in (*one.names, *one.negatives) if flag.startswith("-")]
            yield " ".join((*words, name)), sorted(flags)


def public_names() -> Iterator[str]:
    """Public names of the package and of its subpackages."""
    yield from (f"palpate.{name}" for name in palpate.__all__)
    packages = [f"palpate.{path.parent.name}" for path in sorted(Path(palpate.__file__).parent.glob("*/__init__.py"))]
    packages += PLUGINS
    for package in packages:
        yield from (f"{package}.{name}" for name in importlib.import_module(package).__all__)


def registered() -> Iterator[str]:
    """Kinds of every registry: skins, obstacles, laws, lenses, sources, solvers."""
    from palpate.core import Registry

    found = {}
    for name in list(sys.modules):
        if name.startswith("palpate"):
            found |= {one.group: one for one in vars(sys.modules[name]).values() if isinstance(one, Registry)}
    for group, registry in sorted(found.items()):
        yield from (f"{group}: {name}" for name in registry.names)


def claims() -> list[str]:
    """Claims about the paper, by their numbers, from the package that has them."""
    package = PLUGINS[0] if PLUGINS else "palpate.claims"
    return sorted(str(name) for name in importlib.import_module(f"{package}.claim").CLAIMS)


def main(root: Path) -> None:
    """Print the inventory."""
    project = tomllib.loads((root / "pyproject.toml").read_text())["project"]
    inventory = {
        "verb": [verb for verb, _ in verbs()],
        "flag": [f"{verb} {flag}" for verb, flags in verbs() for flag in flags],
        "name": list(public_names()),
        "kind": list(registered()),
        "study": sorted(path.stem for path in (root / "studies").glob("*.yaml")),
        "example": sorted(path.name for path in (root / "examples").glob("ex*.py")),
        "claim": claims(),
        "extra": sorted(project["optional-dependencies"]),
        "material": sorted(importlib.import_module("palpate.material").list_materials()),
    }
    print(json.dumps({kind: sorted({str(one) for one in found}) for kind, found in inventory.items()}, indent=1))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
