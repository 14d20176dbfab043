"""Operating system locks on files and folders, which end with their process.

``flock`` works on one machine and, by byte ranges, on NFS version 4. If a system or file system has no locks, every
lock is granted: work may then be done twice, but files are still replaced atomically.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

try:
    from fcntl import LOCK_EX, LOCK_NB, flock
except ImportError:  # Windows
    HAS_LOCKS = False
else:
    HAS_LOCKS = True

_HELD_BY_ANOTHER = (errno.EWOULDBLOCK, errno.EAGAIN, errno.EACCES)


@dataclass(frozen=True)
class Lock:
    """Lock that this process holds; its file is removed on release."""

    path: Path
    descriptor: int

    def release(self) -> None:
        """Remove the file, then release the lock, so that a process that opened it before sees its removal."""
        with suppress(OSError):
            self.path.unlink()
        with suppress(OSError):
            os.close(self.descriptor)


def take_lock(path: Path) -> Lock | None:
    """Take the lock of the file `path`, which is created; `None` if another process holds it.

    Raises
    ------
    OSError
        If the file cannot be created.
    """
    while True:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        if not _lock(descriptor):
            os.close(descriptor)
            return None
        if _is_same(descriptor, path):
            return Lock(path, descriptor)
        os.close(descriptor)  # the holder before us removed the file after we had opened it: take the new one


def is_locked(path: Path) -> bool:
    """Return whether a process holds the lock of a file or folder now, without changing it."""
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        return False
    try:
        return not _lock(descriptor)
    finally:
        os.close(descriptor)


@contextmanager
def lock_folder(folder: Path) -> Iterator[None]:
    """Hold the lock of a folder, which marks it as in use."""
    if not HAS_LOCKS:
        yield
        return
    descriptor = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
    try:
        _lock(descriptor)
        yield
    finally:
        os.close(descriptor)


def can_lock(folder: Path) -> bool:
    """Return whether the file system refuses a second lock on `folder`."""
    if not HAS_LOCKS:
        return False
    with lock_folder(folder):
        return is_locked(folder)


def _lock(descriptor: int) -> bool:
    if not HAS_LOCKS:
        return True
    try:
        flock(descriptor, LOCK_EX | LOCK_NB)
    except OSError as error:
        return error.errno not in _HELD_BY_ANOTHER
    return True


def _is_same(descriptor: int, path: Path) -> bool:
    try:
        there = os.stat(path)
    except OSError:
        return False
    here = os.fstat(descriptor)
    return (here.st_dev, here.st_ino) == (there.st_dev, there.st_ino)
