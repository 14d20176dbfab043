"""Test for compiled kernels in the cache on disk."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from palpate.mechanics.element import assemble_cells


def kernels_compiled() -> bool:
    """Test whether a press can start at once; else its kernels are compiled first, in some half a minute."""
    kernel: Any = assemble_cells
    module = assemble_cells.__module__.rsplit(".", 1)[-1]
    return any(Path(kernel.compiled.stats.cache_path).glob(f"{module}.{assemble_cells.__name__}-*.nbi"))
