"""Cores and memory of this machine that a run can use."""

from __future__ import annotations

import math
import os
from contextlib import suppress
from pathlib import Path

WORKER_BYTES = 2**30
"""Memory per worker: presses of the default mesh and trainings take 0.3 to 0.5 GiB."""

_SYSTEM = Path("/proc/meminfo")
_GROUP = Path("/sys/fs/cgroup")


def available_cores() -> int:
    """Number of cores that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # not on every system
        return os.cpu_count() or 1


def available_memory(system: Path = _SYSTEM, group: Path = _GROUP) -> float:
    """Memory that this process can still allocate, bytes; infinite if unknown.

    Parameters
    ----------
    system, group
        Files with the machine's memory and the limit of the container (cgroup 2), on Linux.
    """
    room = math.inf
    with suppress(OSError, KeyError, ValueError):
        room = 1024.0 * _numbers(system)["MemAvailable:"]
    with suppress(OSError, KeyError, ValueError):  # without a limit the file says "max"
        limit = int((group / "memory.max").read_text())
        room = min(room, limit - _numbers(group / "memory.stat")["anon"])
    return max(room, 0.0)


def default_workers() -> int:
    """Number of workers for the available cores and memory; at least one."""
    memory = available_memory()
    fit = available_cores() if math.isinf(memory) else min(available_cores(), int(memory // WORKER_BYTES))
    return max(1, fit)


def _numbers(file: Path) -> dict[str, int]:
    """Return the first number after each name, one a line."""
    rows = (line.split() for line in file.read_text().splitlines())
    return {row[0]: int(row[1]) for row in rows if len(row) > 1}
