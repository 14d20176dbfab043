"""Names that have gone elsewhere: for one version the old ones still work, and say by what they are replaced."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any


def deprecated_names(module: str, names: Mapping[str, tuple[str, str]]) -> Callable[[str], Any]:
    """A module's `__getattr__` (PEP 562) that finds old names under their new ones and warns.

    Parameters
    ----------
    module
        Name of the module.
    names
        Old name → new one in the same module, and the version that takes the old one away.

    Examples
    --------
    >>> find = deprecated_names("math", {"ceiling": ("ceil", "9.0")})
    >>> with warnings.catch_warnings(record=True) as seen:
    ...     warnings.simplefilter("always")
    ...     find("ceiling")(1.2), str(seen[0].message)
    (2, 'math.ceiling is math.ceil now; 9.0 takes the old name away.')
    """

    def find(old: str) -> Any:
        if old not in names:
            raise AttributeError(f"module {module!r} has no attribute {old!r}")
        new, gone = names[old]
        sentence = f"{module}.{old} is {module}.{new} now; {gone} takes the old name away."
        warnings.warn(sentence, DeprecationWarning, stacklevel=2)
        return getattr(import_module(module), new)

    return find
