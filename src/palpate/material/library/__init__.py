"""Materials with a reference: one file each, named author-year with the elastomer."""

from __future__ import annotations

from functools import cache
from importlib import resources

from palpate.material.io import parse_material
from palpate.material.material import Material


@cache
def library_names() -> tuple[str, ...]:
    """Names of the materials in the library."""
    folder = resources.files("palpate.material.library")
    return tuple(sorted(item.name.removesuffix(".yaml") for item in folder.iterdir() if item.name.endswith(".yaml")))


@cache
def read_library(name: str) -> Material:
    """Read one of them."""
    path = resources.files("palpate.material.library") / f"{name}.yaml"
    return parse_material(path.read_text("utf-8"), path.name)
