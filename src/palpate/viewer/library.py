"""Cache of pressed skins of a result folder, read on demand."""

from __future__ import annotations

import threading
from collections import OrderedDict
from dataclasses import dataclass, field

from palpate.viewer.pressed_skin import PressedSkin, build_pressed_skin
from palpate.viewer.results import GridDesign, Results, read_design, read_presses
from palpate.viewer.shell import Shell, build_shell

CACHE_SIZE = 4
"""Number of cached skins: one of the finest standard mesh takes about 60 MB."""


@dataclass(frozen=True, eq=False)
class RenderedSkin:
    """Skin with its presses, ready to be drawn.

    Attributes
    ----------
    pressed, shell
        Its presses, and the drawn surface of its mesh.
    """

    pressed: PressedSkin
    shell: Shell


@dataclass(eq=False)
class DesignLibrary:
    """Designs of a result folder; safe for use from several threads.

    Attributes
    ----------
    results
        The folder and its grid.
    """

    results: Results
    _cache: OrderedDict[tuple[str, ...], RenderedSkin] = field(default_factory=OrderedDict)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def design(self, number: int) -> GridDesign:
        """Return the design of one row; for errors see `read_design`."""
        return read_design(self.results, number)

    def specimen(self, design: GridDesign) -> RenderedSkin:
        """Return skin and presses of a design; for errors see `read_presses`."""
        with self._lock:
            found = self._cache.get(design.press_keys)
            if found is None:
                pressed = build_pressed_skin(read_presses(self.results, design))
                found = self._cache[design.press_keys] = RenderedSkin(pressed, build_shell(pressed.mesh))
                while len(self._cache) > CACHE_SIZE:
                    self._cache.popitem(last=False)
            self._cache.move_to_end(design.press_keys)
            return found
