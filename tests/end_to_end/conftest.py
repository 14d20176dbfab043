"""The file of a study that takes seconds."""

from pathlib import Path

import pytest

from presses import TINY_STUDY


@pytest.fixture(scope="session")
def tiny_study(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("study") / "tiny.yaml"
    path.write_text(TINY_STUDY)
    return path
