"""Compiled kernels: one typed door to numba, with the machine code kept on disk.

numba keeps a function's machine code as long as the function's own file stays as it is, and forgets that other
files are compiled into it: a changed material law would go on unnoticed in the elements. So the machine code lies in
a folder named by all sources that hold kernels, and any change among them makes a new one. A kernel of another
package has those of that package in the name of its folder as well.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
import threading
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import cache, cached_property, update_wrapper
from pathlib import Path
from typing import Any, TypeVar, cast

F = TypeVar("F", bound=Callable[..., Any])

_FOLDER = threading.Lock()
"""Held while numba's folder is that of a kernel, which is a setting of the whole process."""
_MARK = "@kernel"
_PREFIX = "kernels-"
STALE_S = 30 * 86_400.0
"""Time without a use after which the machine code of other sources is removed, s. Twice as long keeps some 10 MB a
version longer; half as long compiles again, in a minute, what is run once in three weeks."""


def kernel(function: F) -> F:
    """Compile `function` by numba to a disk cache, when it is first called; numba is not imported before.

    Floating point may be re-associated, never made unsafe: NaN and infinity keep their meaning, so an inverted
    element can be seen.
    """
    return cast(F, _Kernel(function))


class _Kernel:
    """A function that is compiled when it is first called, by Python or by another kernel."""

    def __init__(self, function: Callable[..., Any]) -> None:
        update_wrapper(self, function)
        self.py_func = function

    @cached_property
    def compiled(self) -> Any:
        numba = _import_numba()
        package, settings = Path(__file__).parents[1], cast(Any, numba.config)
        compile_later = numba.njit(cache=True, nogil=True, fastmath={"reassoc", "contract", "arcp", "nsz"})
        with _FOLDER:
            chosen = settings.CACHE_DIR  # the user's, from NUMBA_CACHE_DIR
            folder = Path(chosen or package / "__pycache__") / f"{_PREFIX}{_stamp(self.py_func, package)}"
            _keep_fresh(folder)
            settings.CACHE_DIR = str(folder)
            try:
                return compile_later(self.py_func)
            finally:
                settings.CACHE_DIR = chosen

    def __call__(self, *arguments: Any) -> Any:
        return self.compiled(*arguments)

    def __reduce__(self) -> str:
        return str(self.py_func.__qualname__)


@cache
def _import_numba() -> Any:
    """numba, which from here on takes a kernel for its compiled function where another kernel uses it."""
    import numba
    from numba.core import types
    from numba.extending import typeof_impl

    @typeof_impl.register(_Kernel)
    def _typeof(value: _Kernel, _: Any) -> Any:
        return types.Dispatcher(value.compiled)

    return numba


@cache
def _keep_fresh(folder: Path) -> None:
    """Say that a folder of machine code is in use, once a process, and remove those beside it that are not."""
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        os.utime(folder)
        remove_stale(folder.parent, {folder.name})


def remove_stale(place: Path, keep: Iterable[str], older_s: float = STALE_S) -> tuple[str, ...]:
    """Remove folders of machine code that nothing has used for a while.

    A folder is renamed before it is emptied, so that no other process sees a part of one; what it has loaded already
    it keeps, and what it misses it compiles. Where two remove at once, one of them finds nothing to rename.

    Parameters
    ----------
    place
        Where the folders lie.
    keep
        Names of folders that stay, however old.
    older_s
        Time in s without a use or a new file after which a folder goes.

    Returns
    -------
    tuple[str, ...]
        Names of those that were removed.
    """
    removed, kept, now = [], set(keep), time.time()
    for folder in sorted(place.glob(f"{_PREFIX}*")):
        if folder.name in kept or not folder.is_dir() or folder.is_symlink():
            continue
        with suppress(OSError):
            used = max(each.stat().st_mtime for each in (folder, *folder.rglob("*")))
            if now - used > older_s:
                aside = folder.with_name(f".{folder.name}.{os.getpid()}")
                folder.rename(aside)
                shutil.rmtree(aside, ignore_errors=True)
                removed.append(folder.name)
    return tuple(removed)


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
