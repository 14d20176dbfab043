"""Test for compiled kernels in the cache on disk."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from palpate.mechanics.element import add_tangent


def kernels_compiled() -> bool:
    """Test whether a press can start at once; else its kernels are compiled first, in some half a minute."""
    kernel: Any = add_tangent
    module = add_tangent.__module__.rsplit(".", 1)[-1]
    return any(Path(kernel.compiled.stats.cache_path).glob(f"{module}.{add_tangent.__name__}-*.nbi"))
