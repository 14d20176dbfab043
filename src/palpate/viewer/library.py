"""Pressed domes of a result folder, read when they are asked for and kept while there is room."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from palpate.fea import Press
from palpate.viewer.pressed_dome import Array32, Motion, PressedDome, gather_presses
from palpate.viewer.results import Design, Results, read_design, read_presses
from palpate.viewer.shell import Shell, build_shell
from palpate.viewer.stress_field import find_stress

KEPT = 4
"""Domes that are kept: a dome of the finest standard mesh takes about 10 MB."""


@dataclass(eq=False)
class Specimen:
    """A dome with its presses, ready to be drawn.

    Attributes
    ----------
    pressed, shell
        Its presses and what is drawn of its mesh.
    """

    pressed: PressedDome
    shell: Shell
    _stress: Array32 | None = None

    def learn_stress(self, presses: Sequence[Press]) -> None:
        """Find the stress of the presses that this dome was gathered from; takes about a second."""
        if self._stress is None:
            self._stress = find_stress(self.pressed, presses)

    @property
    def knows_stress(self) -> bool:
        """Whether the stress was found."""
        return self._stress is not None

    def stress(self, motion: Motion) -> Array32:
        """Von Mises stress (k, n) in MPa for a motion; zero before `learn_stress`."""
        if self._stress is None:
            return np.zeros(motion.displacement.shape[:2], np.float32)
        return self.pressed.blend(self._stress, motion.weights)[..., 0].clip(min=0.0)


@dataclass(eq=False)
class Library:
    """The designs of a result folder; may be asked from several threads.

    Attributes
    ----------
    results
        The folder and its grid.
    """

    results: Results
    _kept: OrderedDict[tuple[str, ...], Specimen] = field(default_factory=OrderedDict)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def design(self, number: int) -> Design:
        """The design of one row; see `read_design` for what may be wrong."""
        return read_design(self.results, number)

    def specimen(self, design: Design) -> Specimen:
        """Dome and presses of a design; see `read_presses` for what may be wrong."""
        with self._lock:
            found = self._kept.get(design.press_keys)
            if found is None:
                pressed = gather_presses(read_presses(self.results, design))
                found = self._kept[design.press_keys] = Specimen(pressed, build_shell(pressed.mesh))
                while len(self._kept) > KEPT:
                    self._kept.popitem(last=False)
            self._kept.move_to_end(design.press_keys)
            return found

    def stressed(self, design: Design) -> Specimen:
        """The same with the stress found; the first call for a dome takes about a second."""
        specimen = self.specimen(design)
        if not specimen.knows_stress:
            specimen.learn_stress(read_presses(self.results, design))
        return specimen
