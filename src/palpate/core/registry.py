"""Registries: implementations of one contract by name, of this package and of installed packages.

An installed package offers an implementation by an entry point (PyPA, *Entry points specification*) in the group of
the contract, declared in its `pyproject.toml`:

    [project.entry-points."palpate.laws"]
    isihara = "my_package.isihara:Isihara"

An implementation is imported when its name is requested, so a defective package affects only its own names.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from functools import cached_property
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Generic, TypeVar, cast, final

from palpate.core.errors import PalpateError

T = TypeVar("T")


@final
class Registry(Generic[T]):
    """Implementations of one contract by name.

    Parameters
    ----------
    group
        Entry point group, e.g. ``palpate.laws``.
    noun
        Name of an implementation in errors, e.g. ``law``.
    own
        Implementations of this package: name → ``module:attribute``. An entry point of the same name is an error, so
        that a name in a file has the same meaning everywhere.
    fits
        Returns whether a loaded entry point is such an implementation.
    remedy
        Additional remedy for an unknown name, one sentence.

    Examples
    --------
    >>> errors = Registry("palpate.errors", "error", {"any": "palpate.core.errors:PalpateError"})
    >>> errors.names
    ('any',)
    >>> errors.get("any").__name__
    'PalpateError'
    """

    def __init__(
        self,
        group: str,
        noun: str,
        own: Mapping[str, str],
        fits: Callable[[Any], bool] | None = None,
        remedy: str = "",
    ) -> None:
        self.group, self.noun = group, noun
        self._own = dict(own)
        self._fits = fits
        self._remedy = remedy or f"A package with an entry point in the group {group} adds another."
        self._loaded: dict[str, T] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """All names: those of this package in their order, then those of other packages, sorted."""
        return (*self._own, *sorted(set(self._offered) - set(self._own)))

    def __contains__(self, name: object) -> bool:
        """Return whether a name exists; its implementation may fail to load."""
        return name in self._own or name in self._offered

    def get(self, name: str) -> T:
        """Load the implementation of a name.

        Raises
        ------
        PalpateError
            If the name is unknown (the error lists the names), two packages offer it, or it cannot be loaded.
        """
        if name not in self:
            raise PalpateError(
                f"Unknown {self.noun} '{name}'.",
                f"Choose one of {', '.join(self.names)}. {self._remedy}",
                code="kind-unknown",
            )
        if name not in self._loaded:
            self._loaded[name] = self._load(name)
        return self._loaded[name]

    def available(self) -> Iterator[tuple[str, T]]:
        """Yield names with their implementations; those that cannot be loaded are left out (see `get`)."""
        for name in self.names:
            with suppress(PalpateError):
                yield name, self.get(name)

    @cached_property
    def _offered(self) -> dict[str, list[EntryPoint]]:
        """Entry points of other packages by name; duplicates on the path count once."""
        offered: dict[str, list[EntryPoint]] = {}
        for point in entry_points(group=self.group):
            same = offered.setdefault(point.name, [])
            if point.value not in [other.value for other in same]:
                same.append(point)
        return offered

    def _load(self, name: str) -> T:
        points = self._offered.get(name, [])
        if len(points) + (name in self._own) > 1:
            sources = (["palpate"] if name in self._own else []) + [_package(point) for point in points]
            raise PalpateError(
                f"The {self.noun} '{name}' is provided by {' and '.join(sources)}.",
                "Uninstall or rename all but one.",
                code="kind-offered-twice",
            )
        if not points:
            module, _, attribute = self._own[name].partition(":")
            return cast(T, getattr(importlib.import_module(module), attribute))
        try:
            loaded = points[0].load()
        except Exception as error:  # whatever another package's import does
            raise PalpateError(
                f"The {self.noun} '{name}' of {_package(points[0])} cannot be loaded: {error}.",
                f"Reinstall {_package(points[0])} with its dependencies, or choose another {self.noun}.",
                code="kind-unloadable",
            ) from error
        if self._fits is not None and not self._fits(loaded):
            raise PalpateError(
                f"{points[0].value} of {_package(points[0])} is not a {self.noun}.",
                f"An entry point of {self.group} must pass the test suite in palpate.testing.",
                code="kind-wrong-type",
            )
        return cast(T, loaded)


def _package(point: EntryPoint) -> str:
    return point.dist.name if point.dist is not None else point.value
