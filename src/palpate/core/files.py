"""Atomic files and folders, and the error if they cannot be written."""

from __future__ import annotations

import errno
import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from palpate.core.errors import PalpateError

if TYPE_CHECKING:
    import h5py

DRAFT = ".writing-"
"""Prefix of the names of incomplete files and folders."""

_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EROFS)
"""Error numbers of a disk that is full, by its size or a quota, or read-only."""


def is_disk_full(error: BaseException | None) -> bool:
    """Return whether an error, or one that caused it, is that of a full or read-only disk."""
    while error is not None and getattr(error, "errno", None) not in _FULL:
        error = error.__cause__
    return error is not None


@contextmanager
def wrap_write_errors(what: Path | str, remedy: str = "Choose another file.") -> Iterator[None]:
    """Raise every `OSError` of the block as a `PalpateError` with the path, the reason and the remedy."""
    try:
        yield
    except OSError as error:
        raise PalpateError(
            f"{what} cannot be written: {error.strerror or error}.",
            remedy,
            code="disk-unwritable" if is_disk_full(error) else "file-unwritable",
        ) from error


@contextmanager
def create_hdf5(path: Path) -> Iterator[h5py.File]:
    """Create an HDF5 file, which is written to the disk if the block ends without an error.

    It is built in memory, because HDF5 crashes with a segmentation fault if the disk is full; here that is an
    `OSError`.
    """
    import h5py

    with h5py.File(path.name, "w", driver="core", backing_store=False) as file:
        yield file
        file.flush()
        image = file.id.get_file_image()
    path.write_bytes(image)


@contextmanager
def atomic_write(path: Path, remedy: str = "Choose another file.") -> Iterator[Path]:
    """Yield a path in a temporary folder; a file written there replaces `path` if the block succeeds.

    Raises
    ------
    PalpateError
        If the file cannot be written.
    """
    with wrap_write_errors(path, remedy), _drafts(path.parent) as folder:
        yield folder / path.name


@contextmanager
def atomic_write_into(folder: Path, remedy: str = "Choose another folder.") -> Iterator[Path]:
    """Yield an empty folder inside `folder`, which is created; its files move up if the block succeeds.

    Raises
    ------
    PalpateError
        If the folder cannot be written.
    """
    with wrap_write_errors(folder, remedy):
        folder.mkdir(parents=True, exist_ok=True)
        with _drafts(folder) as drafts:
            yield drafts


@contextmanager
def atomic_folder(folder: Path, remedy: str = "Choose another folder.") -> Iterator[Path]:
    """Yield a temporary folder, which becomes `folder` if the block succeeds and is removed otherwise.

    Raises
    ------
    PalpateError
        If `folder` is not empty, or cannot be written.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise PalpateError(
            f"{folder} exists and is not an empty folder.",
            "Choose another folder, or remove it.",
            code="folder-exists",
        )
    with wrap_write_errors(folder, remedy):
        folder.parent.mkdir(parents=True, exist_ok=True)
        draft = Path(tempfile.mkdtemp(prefix=DRAFT, dir=folder.parent))
        try:
            yield draft
            draft.chmod(0o755)
            if folder.exists():
                folder.rmdir()
            draft.replace(folder)
        finally:
            shutil.rmtree(draft, ignore_errors=True)


@contextmanager
def _drafts(folder: Path) -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix=DRAFT, dir=folder) as name:
        yield Path(name)
        for draft in sorted(Path(name).iterdir()):
            os.replace(draft, folder / draft.name)


def natural_key(name: str) -> list[tuple[int, str]]:
    """Return a sort key by which ``frame_2`` comes before ``frame_10``: numbers are compared by value."""
    parts = re.findall(r"([0-9]+)|([^0-9]+)", name)
    return [*((int(digits), "") if digits else (-1, text) for digits, text in parts), (-2, name)]
