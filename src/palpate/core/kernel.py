"""Compiled kernels: one typed door to numba, with the machine code kept on disk.

numba keeps a function's machine code as long as the function's own file stays as it is, and forgets that other
files are compiled into it: a changed material law would go on unnoticed in the elements. So the machine code lies in
a folder named by all sources that hold kernels, and any change among them makes a new one. A kernel of another
package has those of that package in the name of its folder as well.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar, cast

F = TypeVar("F", bound=Callable[..., Any])

_MARK = "@kernel"


def kernel(function: F) -> F:
    """Compile `function` by numba to a disk cache; floating point may be re-associated, never made unsafe.

    NaN and infinity keep their meaning, so an inverted element can be seen.
    """
    import numba  # here, so that a front door without kernels opens fast

    package, settings = Path(__file__).parents[1], cast(Any, numba.config)
    chosen = settings.CACHE_DIR  # the user's, from NUMBA_CACHE_DIR
    settings.CACHE_DIR = str(Path(chosen or package / "__pycache__") / f"kernels-{_stamp(function, package)}")
    try:
        compiled = numba.njit(cache=True, nogil=True, fastmath={"reassoc", "contract", "arcp", "nsz"})(function)
    finally:
        settings.CACHE_DIR = chosen
    return cast(F, compiled)


def _stamp(function: Callable[..., Any], package: Path) -> str:
    outside = sys.modules.get(function.__module__.partition(".")[0])
    folder = next(iter(getattr(outside, "__path__", ())), None)
    if folder is None or Path(folder).resolve() == package.resolve():
        return kernel_stamp(package)
    return f"{kernel_stamp(package)}-{kernel_stamp(Path(folder))}"


@cache
def kernel_stamp(package: Path) -> str:
    """Hash of every source file below `package` that holds kernels."""
    digest = hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        text = path.read_bytes()
        if _MARK.encode() in text:
            digest.update(path.relative_to(package).as_posix().encode() + b"\0" + text)
    return digest.hexdigest()[:16]
