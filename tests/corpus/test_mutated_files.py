"""Mutated files at every door are read, or refused in a sentence: a few files each, and 300 by the slow tier."""

import contextlib
from pathlib import Path

import pytest
from fuzz import DOORS, faults, run

CHEAP = [name for name in DOORS if name not in ("boards", "rest.png", "profile.step", "press.h5", "model.h5")]


@pytest.mark.parametrize("name", CHEAP)
def test_a_mutated_file_is_read_or_refused_in_a_sentence(name: str, tmp_path: Path) -> None:
    with contextlib.chdir(tmp_path):
        assert list(faults(name, 4, tmp_path / "door")) == []


@pytest.mark.slow
def test_300_mutated_files_are_read_or_refused_in_a_sentence() -> None:
    assert run(300, list(DOORS), seed=1) == []
