"""Vectors with named entries."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, overload

import numpy as np

from palpate.core.arrays import FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class State:
    """Vector, or vectors along the last axis of an array, with named entries.

    Attributes
    ----------
    names
        Name of each entry.
    values
        (..., n) entries in the order of the names.

    Examples
    --------
    >>> contact = State(("depth_mm", "inverse_friction"), np.array([2.0, 0.5]))
    >>> contact["inverse_friction"], contact.replace(depth_mm=3.0).to_array(("depth_mm",)).tolist()
    (0.5, [3.0])
    """

    names: tuple[str, ...]
    values: FloatArray

    def __post_init__(self) -> None:
        if self.values.shape[-1] != len(self.names):
            raise TypeError(f"{self.values.shape[-1]} values for the names {', '.join(self.names)}.")

    @classmethod
    def from_mapping(cls, values: Mapping[str, float]) -> State:
        """Return the state with these entries."""
        return cls(tuple(values), np.array(list(values.values()), float))

    @classmethod
    def zeros(cls, names: tuple[str, ...]) -> State:
        """Return the state whose entries are 0."""
        return cls(names, np.zeros(len(names)))

    def __len__(self) -> int:
        return len(self.names)

    @overload
    def __getitem__(self, name: str) -> Any: ...  # a float, or an array of several vectors

    @overload
    def __getitem__(self, name: tuple[str, ...]) -> FloatArray: ...

    def __getitem__(self, name: str | tuple[str, ...]) -> Any:
        """Return an entry, or entries (..., k), by name.

        Raises
        ------
        TypeError, KeyError
            If a number is given, or a name that is not among the names.
        """
        if isinstance(name, tuple):
            return self.to_array(name)
        found = self.values[..., self._place(name)]
        return float(found) if self.values.ndim == 1 else found

    def to_array(self, names: Iterable[str]) -> FloatArray:
        """Return the entries (..., k) of these names, in their order."""
        return self.values[..., indices(self.names, tuple(names))]

    def replace(self, **entries: float) -> State:
        """Return the state with other entries of these names."""
        values = self.values.copy()
        for name, entry in entries.items():
            values[..., self._place(name)] = entry
        return State(self.names, values)

    def add(self, names: tuple[str, ...], change: FloatArray) -> State:
        """Return the state with a change (..., k) added to the entries of these names."""
        values = self.values.copy()
        values[..., indices(self.names, names)] += change
        return State(self.names, values)

    def __add__(self, other: State) -> State:
        """Return the sum with a state of the same names."""
        return State(self.names, self.values + other.to_array(self.names))

    def __sub__(self, other: State) -> State:
        """Return the difference from a state of the same names."""
        return State(self.names, self.values - other.to_array(self.names))

    def _place(self, name: str) -> int:
        if not isinstance(name, str):
            raise TypeError(f"{name!r} is not a name; the entries are {', '.join(self.names)}.")
        return int(indices(self.names, (name,))[0])


@lru_cache(maxsize=1024)
def indices(names: tuple[str, ...], chosen: tuple[str, ...]) -> IntArray:
    """Return the places (k,) of chosen names among names.

    Raises
    ------
    TypeError, KeyError
        If a chosen name is not a text, or not among the names.
    """
    if not all(isinstance(name, str) for name in chosen):
        raise TypeError(f"{chosen!r} are not names; the entries are {', '.join(names)}.")
    if unknown := set(chosen) - set(names):
        raise KeyError(f"no entry {', '.join(sorted(unknown))} among {', '.join(names)}")
    return np.array([names.index(name) for name in chosen], dtype=np.intp)
