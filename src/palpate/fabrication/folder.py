"""Checksums of the files of a folder."""

from __future__ import annotations

import hashlib
from pathlib import Path


def hash_files(folder: Path) -> dict[str, str]:
    """Return the SHA-256 of every file of a folder, by relative name."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}
