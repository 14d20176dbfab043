"""A folder that is written whole or not at all."""

from __future__ import annotations

import hashlib
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from palpate.core import PalpateError


@contextmanager
def new_folder(folder: Path) -> Iterator[Path]:
    """A folder beside the one asked for, which takes its place when the block ends well and vanishes when not.

    Raises
    ------
    PalpateError
        If `folder` holds something, or cannot be written.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise PalpateError(f"{folder} exists and is not an empty folder.", "Choose another, or remove it.")
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        work = Path(tempfile.mkdtemp(prefix=f".{folder.name}-", dir=folder.parent))
    except OSError as error:
        raise PalpateError(f"The folder {folder} cannot be written: {error.strerror}.", "Choose another.") from error
    try:
        yield work
        if folder.exists():
            folder.rmdir()
        work.chmod(0o755)
        work.replace(folder)
    except BaseException:
        shutil.rmtree(work, ignore_errors=True)
        raise


def hash_files(folder: Path) -> dict[str, str]:
    """SHA-256 of every file of a folder, by its name there."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}
