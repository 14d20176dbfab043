"""Pins in the core of a mold and on the module, by their volume and by what the sheet says."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from palpate.design import Design, DomeSpec, MarkerSpec, MountSpec
from palpate.design.pinned import PinnedSpec
from palpate.design.solid import read_step
from palpate.fabrication import ProcessSpec, write_pack
from palpate.fabrication.write_pack import _make

DESIGN = Design(PinnedSpec(height=18, base_radius=18, thickness=1, pin=2), MarkerSpec(count=19, diameter=1.2))
PINS_MM3 = 20 * np.pi / 4 * 1.2**2 * 2.0
"""Of 19 markers and the orientation mark; a root that is round instead of flat adds less than 1 %."""


@pytest.mark.slow
def test_a_pack_of_pins_fills_them_from_the_core(tmp_path: Path) -> None:
    pack = write_pack(tmp_path / "pack", DESIGN)
    dome = replace(DESIGN, skin_spec=DomeSpec(height=18, base_radius=18, thickness=1))
    bare = _make(dome, ProcessSpec(), MountSpec()).solids
    scale = 1 / (1 - ProcessSpec().shrinkage_percent / 100)
    for name, size, sign in (("module", 1.0, 1), ("mold_core", scale**3, -1)):
        assert sign * (pack.volumes[name] - bare[name].volume) == pytest.approx(size * PINS_MM3, rel=0.02)
    assert read_step(tmp_path / "pack" / "module.step")["module"].pieces == 1
    sheet = (tmp_path / "pack" / "instructions.md").read_text()
    assert "artwork.pdf" in sheet
    assert "artwork.dxf" not in sheet
    assert not list((tmp_path / "pack").glob("template*"))
