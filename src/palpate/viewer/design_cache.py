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
    """Designs by name: the number of a row, or the name that `put` gave.

    Attributes
    ----------
    library
        Designs of the result folder; `None` without one.
    """

    library: DesignLibrary | None = None
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
        if self.library is None or not (name.isascii() and name.isdigit() and len(name) < 8):
            raise PalpateError(
                f"There is no design '{name[:40]}' any more.", "Load the page again.", code="design-expired"
            )
        design = self.library.design(int(name))
        return design, self.library.specimen(design)
