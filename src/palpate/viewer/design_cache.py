"""Designs that the page can show: those of the result folder, and those made on the page."""

from __future__ import annotations

import threading
from collections import OrderedDict
from dataclasses import dataclass, field

from palpate.core import PalpateError
from palpate.viewer.library import DesignLibrary, RenderedSkin
from palpate.viewer.results import GridDesign

CACHE_SIZE = 24
"""Number of cached designs of the page; a skin at rest takes about 1 MB."""


@dataclass(eq=False)
class DesignCache:
    """Designs by name: result and number of a row (``"first/3"``), or the name that `put` gave.

    Attributes
    ----------
    libraries
        Designs of each opened study by its name; that of a study that was given itself is empty.
    """

    libraries: dict[str, DesignLibrary] = field(default_factory=dict)
    _made: OrderedDict[str, tuple[GridDesign, RenderedSkin]] = field(default_factory=OrderedDict)
    _count: int = 0
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def put(self, design: GridDesign, specimen: RenderedSkin) -> str:
        """Store a design made on the page and return its name."""
        with self._lock:
            self._count += 1
            name = f"made-{self._count}"
            self._made[name] = (design, specimen)
            while len(self._made) > CACHE_SIZE:
                self._made.popitem(last=False)
            return name

    def find(self, name: str) -> tuple[GridDesign, RenderedSkin]:
        """Return a design with its presses.

        Raises
        ------
        PalpateError
            If the design does not exist, or its presses are missing or broken.
        """
        if name in self._made:
            return self._made[name]
        result, _, number = name.rpartition("/")
        library = self.libraries.get(result)
        if library is None or not (number.isascii() and number.isdigit() and len(number) < 8):
            raise PalpateError(
                f"There is no design '{name[:40]}' any more.", "Load the page again.", code="design-expired"
            )
        design = library.design(int(number))
        return design, library.specimen(design)
