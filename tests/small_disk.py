"""A file system of a given size, for tests of full disks."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest


@contextmanager
def mounted(folder: Path, size_kib: int) -> Iterator[Path]:
    """Mount a file system of so many KiB at a new folder; skip the test where this user may not."""
    folder.mkdir()
    words = ["mount", "-t", "tmpfs", "-o", f"size={size_kib}k", "none", str(folder)]
    if sys.platform != "linux" or subprocess.run(words, capture_output=True).returncode != 0:
        pytest.skip("only the administrator of a Linux system can mount a small disk")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "-l", str(folder)], check=True)
