"""Recordings inside a result folder: folders of images, and files that a source of images opens."""

from __future__ import annotations

from pathlib import Path

from palpate.camera import list_images, recording_suffixes
from palpate.core import PalpateError

_DEEPEST_SEARCH = 2
"""Depth of folders in which recordings are searched."""


def find_recordings(folder: Path) -> tuple[str, ...]:
    """Names of image folders and source files, relative to a result folder, without its store."""
    found = []
    places = [(folder, 0)]
    while places:
        place, depth = places.pop()
        for path in sorted(place.iterdir()):
            if path.suffix.lower() in recording_suffixes() and path.is_file() and not path.is_symlink():
                found.append(str(path.relative_to(folder)))
            if path.is_symlink() or not path.is_dir() or path.name.startswith(".") or path == folder / "store":
                continue
            if _has_images(path):
                found.append(str(path.relative_to(folder)))
            if depth + 1 < _DEEPEST_SEARCH:
                places.append((path, depth + 1))
    return tuple(sorted(found))


def inside(folder: Path, name: str) -> Path:
    """Return a folder or recording inside a folder by its relative name.

    Raises
    ------
    PalpateError
        If it is outside, after links are resolved, or is not a recording.
    """
    root = folder.resolve()
    try:
        path = (root / name).resolve()
    except (OSError, ValueError, RuntimeError):
        path = root.parent
    known = path.is_dir() or (path.is_file() and path.suffix.lower() in recording_suffixes())
    if path == root or not path.is_relative_to(root) or not known:
        raise PalpateError(
            f"There is no recording '{name[:60]}' in {folder.name}.",
            "Choose one from the list.",
            code="recording-unknown",
        )
    return path


def _has_images(folder: Path) -> bool:
    try:
        return bool(list_images(folder))
    except PalpateError:
        return False
