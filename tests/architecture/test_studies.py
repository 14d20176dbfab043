"""The folder `studies` shows the presets of the package, byte for byte.

Links would do on Linux alone: where a zip is unpacked on Windows, a link becomes a file that holds a path.
"""

from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
STUDIES, PRESETS = ROOT / "studies", ROOT / "src" / "palpate" / "study" / "presets"


def test_every_preset_is_a_study_and_every_study_a_preset() -> None:
    assert {path.name for path in STUDIES.iterdir()} == {path.name for path in PRESETS.iterdir()}


@pytest.mark.parametrize("path", sorted(PRESETS.iterdir()), ids=lambda path: path.stem)
def test_a_study_is_its_preset(path: Path) -> None:
    assert (STUDIES / path.name).read_bytes() == path.read_bytes(), f"copy {path} to {STUDIES}: the package's counts"
