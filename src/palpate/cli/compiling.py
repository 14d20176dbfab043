"""Notice that the first press after an installation compiles the kernels."""

from __future__ import annotations

import sys


def announce_compilation() -> None:
    """Print to standard error, once after an installation, that the kernels are compiled."""
    from palpate.mechanics import kernels_compiled

    if not kernels_compiled():
        print("Compiling the kernels, once after installation: about half a minute.", file=sys.stderr, flush=True)
