"""Molds of dumbbells and cylinders."""

import json

import numpy as np
import pytest

from errors import refused
from needs import needs
from palpate.design import Arc
from palpate.design.solid import read_step
from palpate.fabrication import ProcessSpec, build_specimen_molds, write_specimen_molds
from palpate.fabrication.specimen import outline_dumbbell

needs("build123d")


def test_build_specimen_molds_leave_the_specimens_hollow_after_shrinkage() -> None:
    spec = ProcessSpec(shrinkage_percent=2.0)
    for mold in build_specimen_molds(spec, 3):
        low, high = mold.tray.bounds
        hollow = np.prod(high - low) - mold.tray.volume
        assert hollow * 0.98**3 == pytest.approx(3 * mold.specimen.volume, rel=1e-6)
        assert mold.tray.pieces == 1


def test_the_dumbbell_has_the_sizes_of_the_standard() -> None:
    dumbbell, button = build_specimen_molds(ProcessSpec(), 1)
    assert dumbbell.specimen.bounds == pytest.approx(np.array([[-57.5, -12.5, 0], [57.5, 12.5, 3]]), abs=1e-6)
    assert button.specimen.volume == pytest.approx(np.pi * 14.5**2 * 12.5)
    outline = outline_dumbbell()
    assert outline[0] == (-16.5, 3.0)
    inside, outside = outline[2], outline[3]
    assert isinstance(inside, Arc)
    assert isinstance(outside, Arc)
    for point in (inside.through, inside.end):
        assert np.hypot(point[0] - 16.5, point[1] - 28.0) == pytest.approx(25.0)  # about (16.5, 3 + 25)
    middle = (outside.end[0], 12.5 - 14.0)
    for point in (inside.end, outside.through, outside.end):
        assert np.hypot(point[0] - middle[0], point[1] - middle[1]) == pytest.approx(14.0)


def test_write_specimen_molds_leaves_files_that_can_be_read(tmp_path) -> None:
    files = write_specimen_molds(tmp_path / "molds", ProcessSpec(), 2)
    assert len(files) == 6
    assert set(read_step(tmp_path / "molds" / "dumbbell.step")) == {"specimen", "tray"}
    manifest = json.loads((tmp_path / "molds" / "manifest.json").read_text())
    assert manifest["elastomer_ml"]["cylinder"] == pytest.approx(2 * np.pi * 14.5**2 * 12.5 / 1000)


def test_a_tray_for_none_is_refused() -> None:
    with refused("tray-count", "0"):
        build_specimen_molds(ProcessSpec(), 0)
