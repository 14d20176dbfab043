"""A full disk: one sentence with the folder of finished results, exit code 2, nothing finished lost."""

import errno
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from palpate.cli.border import guarded, keep_results
from palpate.core import ArtefactStore, PalpateError, Recipe, atomic_write


def through_store(folder: Path) -> None:
    ArtefactStore(folder / "store").write(Recipe("sum", [1.0]), lambda path: raise_full())


def through_file(folder: Path) -> None:
    with atomic_write(folder / "grid.csv"):
        raise_full()


def wrapped(folder: Path) -> None:
    try:
        raise_full()
    except OSError as error:
        raise PalpateError(f"{folder / 'model.h5'} cannot be written.", "Choose another.", code="other") from error


def raise_full(code: int = errno.ENOSPC) -> None:
    raise OSError(code, "No space left on device")


@pytest.mark.parametrize(
    "write",
    [
        through_store,
        through_file,
        wrapped,
        lambda folder: raise_full(),
        lambda folder: raise_full(errno.EDQUOT),
        lambda folder: raise_full(errno.EROFS),
    ],
    ids=["store", "file", "wrapped", "bare", "quota", "read-only"],
)
def test_one_sentence_names_the_folder_and_the_way_on(
    write: Callable[[Path], Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def command() -> None:
        write(keep_results(tmp_path))

    assert guarded(command) == 2
    text = capsys.readouterr().err
    assert text.count("\n") == 1
    assert str(tmp_path) in text
    assert "run the same command again" in text
    assert text.rstrip().endswith("[disk-unwritable]")


def test_other_write_errors_keep_their_remedy(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    def command() -> None:
        with atomic_write(tmp_path / "grid.csv", "Choose another with --out."):
            raise OSError(errno.EACCES, "Permission denied")

    assert guarded(command) == 2
    text = capsys.readouterr().err
    assert "--out" in text
    assert "[file-unwritable]" in text
