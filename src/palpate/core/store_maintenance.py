"""Maintenance of a store: list, check for corruption, and remove unused files."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

from palpate.core.files import DRAFT
from palpate.core.store import BROKEN, LOCK, MANIFEST, REASON, StoreError, find_corruption, quarantine
from palpate.core.store_lock import can_lock, is_locked, take_lock

UNLOCKED_DRAFT_S = 86_400.0
"""Time without a change after which the folder of an artefact in progress counts as abandoned, s.

It applies to file systems without locks.
"""


@dataclass(frozen=True)
class StoreContents:
    """Contents of a store, by the names of its files alone.

    Attributes
    ----------
    artefacts
        Kind and file name of every artefact with a manifest.
    quarantined
        Kind and file name of every quarantined artefact.
    working
        Kind and key of every artefact that a process is making now.
    """

    artefacts: frozenset[tuple[str, str]]
    quarantined: frozenset[tuple[str, str]]
    working: frozenset[tuple[str, str]]


@dataclass(frozen=True)
class CorruptArtefact:
    """Corrupt artefact: its path, and the reason in one sentence."""

    path: Path
    reason: str


@dataclass(frozen=True)
class Removal:
    """Removable file or folder: its path, its size in bytes, and the reason."""

    path: Path
    size: int
    reason: str


def list_store(root: Path) -> StoreContents:
    """List a store by its folders; only the locks, one per running task, are opened."""
    artefacts, manifests, quarantined, working = set(), set(), set(), set()
    for kind, entry in _entries(root):
        name = entry.name
        if name.endswith(MANIFEST):
            manifests.add((kind, name.removesuffix(MANIFEST)))
        elif name.endswith(BROKEN):
            quarantined.add((kind, name))
        elif name.endswith(LOCK):
            if is_locked(Path(entry.path)):
                working.add((kind, name.removesuffix(LOCK)))
        elif _is_artefact(name):
            artefacts.add((kind, name))
    whole = {(kind, name) for kind, name in artefacts if (kind, _key(name)) in manifests}
    return StoreContents(frozenset(whole), frozenset(quarantined), frozenset(working))


def check_store(root: Path) -> tuple[int, tuple[CorruptArtefact, ...]]:
    """Read every artefact of a store and quarantine the corrupt ones.

    Returns
    -------
    tuple
        Number of artefacts read, and the corrupt ones, which a run of their study makes again.
    """
    read, broken = 0, []
    for _, entry in _entries(root):
        if not _is_artefact(entry.name):
            continue
        read += 1
        path = Path(entry.path)
        reason = _fault(path)
        if reason:
            quarantine(path, reason)
            broken.append(CorruptArtefact(path, reason))
    return read, tuple(broken)


def clean_store(root: Path, needed: Collection[str], *, dry_run: bool = False) -> tuple[Removal, ...]:
    """Remove unused files: artefacts of other keys, corrupt ones, and remains of killed processes.

    Parameters
    ----------
    root
        Folder of the store.
    needed
        Keys of the artefacts that stay, with their manifests and journals.
    dry_run
        Remove nothing.

    Returns
    -------
    tuple[Removal, ...]
        Removed files, or with `dry_run` those that would be. Artefacts in progress are kept.

    Raises
    ------
    StoreError
        If something cannot be removed.
    """
    keys = frozenset(needed)
    found = tuple(removal for _, entry in _entries(root) if (removal := _classify(entry, keys)) is not None)
    if not dry_run:
        for removal in found:
            _remove(removal.path)
    return found


def _classify(entry: os.DirEntry[str], needed: frozenset[str]) -> Removal | None:
    name, path = entry.name, Path(entry.path)
    if entry.is_dir(follow_symlinks=False):
        if name.startswith(DRAFT) and _is_left_behind(path):
            size = sum(item.stat().st_size for item in path.rglob("*") if item.is_file())
            return Removal(path, size, "left behind by a process that was ended")
        return None
    size = entry.stat(follow_symlinks=False).st_size
    if name.endswith((BROKEN, REASON)):
        return Removal(path, size, "quarantined")
    key = _key(name)
    if name.endswith(LOCK):
        return None if is_locked(path) else Removal(path, size, "left behind by a process that was ended")
    if key in needed or is_locked(path.with_name(key + LOCK)):
        return None
    return Removal(path, size, "needed by none of the studies")


def _is_left_behind(draft: Path) -> bool:
    if is_locked(draft):
        return False
    return can_lock(draft) or time.time() - draft.stat().st_mtime > UNLOCKED_DRAFT_S


def _remove(path: Path) -> None:
    try:
        if path.is_dir():
            shutil.rmtree(path)
        elif path.name.endswith(LOCK):
            lock = take_lock(path)
            if lock is not None:
                lock.release()
        else:
            path.unlink()
    except FileNotFoundError:
        return
    except OSError as error:
        raise StoreError(
            f"{path} cannot be removed: {error.strerror or error}.",
            "Check the write permission of the folder.",
            code="store-file-not-removed",
        ) from error


def _fault(path: Path) -> str:
    try:
        return find_corruption(path)
    except FileNotFoundError:  # another process set it aside while we looked
        return ""
    except OSError as error:
        return f"It cannot be read: {error.strerror or error}."


def _is_artefact(name: str) -> bool:
    return not name.startswith(".") and not name.endswith((MANIFEST, BROKEN, REASON, LOCK, ".journal"))


def _key(name: str) -> str:
    return name.split(".", 1)[0]


def _entries(root: Path) -> Iterator[tuple[str, os.DirEntry[str]]]:
    """Yield all files and folders of artefacts, with their kind."""
    for kind in _scan(root):
        if not kind.is_dir(follow_symlinks=False):
            continue
        for shelf in _scan(kind.path):
            if shelf.is_dir(follow_symlinks=False):
                for entry in _scan(shelf.path):
                    yield kind.name, entry


def _scan(folder: Path | str) -> list[os.DirEntry[str]]:
    try:
        with os.scandir(folder) as entries:
            return list(entries)
    except (FileNotFoundError, NotADirectoryError):
        return []
