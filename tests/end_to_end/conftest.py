"""A study of minutes cut down to seconds: coarse mesh, three tilts, shallow presses, tiny learning."""

from pathlib import Path

import pytest

STUDY = """
name: tiny
seed: 3
designs:
  heights: [20 mm]
  thicknesses: [2 mm]
  markers: [7, 19]
mesh: {cells: 8}
tilts_deg: [0, 3, 6]
wall: {depth: 4 mm}
dataset: {n_presses: 60, max_tilt_deg: 6}
learning: {preset: quick}
"""


@pytest.fixture(scope="session")
def tiny_study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("study") / "tiny.yaml"
    path.write_text(STUDY)
    return path
