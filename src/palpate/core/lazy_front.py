"""Public names of a subpackage, imported on first use, so that a command loads only its own modules.

The stub `__init__.pyi` lists them, as in scientific Python's SPEC 1: tools and type checkers read it like an
`__init__.py` of imports.
"""

from __future__ import annotations

import ast
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any


class _LazyFront(ModuleType):
    """A package whose public names are imported on first use."""

    def __getattr__(self, name: str) -> Any:
        sources: dict[str, tuple[str, str]] = self.__dict__["_sources"]
        if name not in sources:
            raise AttributeError(f"module '{self.__name__}' has no attribute '{name}'")
        source, original = sources[name]
        value = getattr(import_module(source), original)
        setattr(self, name, value)
        return value

    def __setattr__(self, name: str, value: Any) -> None:
        """Keep a public name that a submodule shares: importing the submodule would replace it by the module."""
        if not (name in self.__dict__["_sources"] and isinstance(value, ModuleType)):
            super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        return sorted({*self.__dict__, *self.__dict__["_sources"]})


def lazy_front(package: str, file: str) -> None:
    """Make a package, by its ``__name__`` and ``__file__``, import each name of its stub on first use.

    The stub ``__init__.pyi`` is in the same folder.
    """
    module = sys.modules[package]
    stub = ast.parse(Path(file).with_suffix(".pyi").read_text("utf-8"))
    module.__dict__["_sources"] = {
        alias.asname or alias.name: (str(node.module), alias.name)
        for node in stub.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    module.__dict__["__all__"] = list(module.__dict__["_sources"])
    module.__class__ = _LazyFront
