"""Pressed domes of a result folder, read when they are asked for and kept while there is room."""

from __future__ import annotations

import threading
from collections import OrderedDict
from dataclasses import dataclass, field

from palpate.viewer.pressed_skin import PressedSkin, build_pressed_skin
from palpate.viewer.results import GridDesign, Results, read_design, read_presses
from palpate.viewer.shell import Shell, build_shell

CACHE_SIZE = 4
"""Domes that are kept: a dome of the finest standard mesh takes about 60 MB."""


@dataclass(frozen=True, eq=False)
class RenderedSkin:
    """A dome with its presses, ready to be drawn.

    Attributes
    ----------
    pressed, shell
        Its presses and what is drawn of its mesh.
    """

    pressed: PressedSkin
    shell: Shell


@dataclass(eq=False)
class DesignLibrary:
    """The designs of a result folder; may be asked from several threads.

    Attributes
    ----------
    results
        The folder and its grid.
    """

    results: Results
    _cache: OrderedDict[tuple[str, ...], RenderedSkin] = field(default_factory=OrderedDict)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def design(self, number: int) -> GridDesign:
        """The design of one row; see `read_design` for what may be wrong."""
        return read_design(self.results, number)

    def specimen(self, design: GridDesign) -> RenderedSkin:
        """Dome and presses of a design; see `read_presses` for what may be wrong."""
        with self._lock:
            found = self._cache.get(design.press_keys)
            if found is None:
                pressed = build_pressed_skin(read_presses(self.results, design))
                found = self._cache[design.press_keys] = RenderedSkin(pressed, build_shell(pressed.mesh))
                while len(self._cache) > CACHE_SIZE:
                    self._cache.popitem(last=False)
            self._cache.move_to_end(design.press_keys)
            return found
