"""Contract suite of readers of recordings."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from palpate.core import PalpateError
from palpate.datasets import READERS, RecordingReader, read_recording


class RecordingReaderSuite:
    """Inherit and give the fixtures `place` and `damaged`; pytest collects the rest."""

    @pytest.fixture
    def place(self, tmp_path: Path) -> Path:
        """A file or folder of the format, with 8 images or more of 8 presses or more."""
        raise NotImplementedError("Give the fixture `place`.")

    @pytest.fixture
    def damaged(self, tmp_path: Path) -> Path:
        """A file or folder that the reader accepts and that cannot be read."""
        raise NotImplementedError("Give the fixture `damaged`.")

    @pytest.fixture
    def reader(self, place: Path) -> RecordingReader:
        """The one reader that accepts the place."""
        (found,) = [reader for _, reader in READERS.available() if reader.accepts(place)]
        return found()

    def test_its_formats_are_named(self, reader: RecordingReader) -> None:
        assert reader.formats.strip()

    def test_it_accepts_nothing_else(self, reader: RecordingReader, tmp_path: Path) -> None:
        (tmp_path / "empty").mkdir()
        (tmp_path / "notes.rtf").write_text("no recording")
        assert not reader.accepts(tmp_path / "empty")
        assert not reader.accepts(tmp_path / "notes.rtf")

    def test_the_table_has_a_row_for_each_image(self, reader: RecordingReader, place: Path) -> None:
        table, images = reader.read(place)
        assert len(table) >= 12
        assert all(len(values) == len(table) for values in table.columns.values())
        if images is not None:
            found = list(images.read([0, len(table) - 1]))
            assert all(isinstance(image, np.ndarray) and image.ndim in (2, 3) for image in found)
            assert images.stamp(0) != images.stamp(len(table) - 1)

    def test_it_becomes_a_recording_with_poses_and_presses(self, place: Path) -> None:
        recording = read_recording(place)
        assert len(recording) + recording.rest >= 12
        assert np.isfinite(recording.targets).all()
        assert recording.presses >= 8

    def test_a_damaged_one_is_refused_by_one_sentence(self, damaged: Path) -> None:
        with pytest.raises(PalpateError) as refused:
            read_recording(damaged)
        assert refused.value.problem.strip().endswith(".")
        assert refused.value.code
