"""Compiled kernels: a typed interface to numba, with machine code cached on disk.

numba's cache is valid as long as the function's own file is unchanged, and ignores other files that are compiled into
it: elements would keep an old material law. So the cache folder is named by a hash of all sources with kernels, and
any change creates a new one. For a kernel of another package, the name includes a hash of that package as well.
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
"""Lock of numba's cache folder, a setting of the whole process, while it is that of a kernel."""
_MARK = "@kernel"
_PREFIX = "kernels-"
STALE_S = 30 * 86_400.0
"""Time without use after which the machine code of other sources is removed, s.

Twice this time would keep some 10 MB per version longer; half of it would recompile, in a minute, code used every
three weeks.
"""


def kernel(function: F) -> F:
    """Compile `function` by numba to a disk cache on its first call; numba is not imported before.

    Floating point may be re-associated, but NaN and infinity are preserved, so that inverted elements are detected.
    """
    return cast(F, _Kernel(function))


class _Kernel:
    """Function that is compiled on its first call, by Python or by another kernel."""

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
    """Import numba, and register the type by which a kernel can call another kernel."""
    import numba
    from numba.core import types
    from numba.extending import typeof_impl

    @typeof_impl.register(_Kernel)
    def _typeof(value: _Kernel, _: Any) -> Any:
        return types.Dispatcher(value.compiled)

    return numba


@cache
def _keep_fresh(folder: Path) -> None:
    """Mark a folder of machine code as used, once per process, and remove unused ones next to it."""
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        os.utime(folder)
        remove_stale(folder.parent, {folder.name})


def remove_stale(place: Path, keep: Iterable[str], older_s: float = STALE_S) -> tuple[str, ...]:
    """Remove unused folders of machine code from `place`, except those named `keep`; return their names.

    A folder is removed if it has not been used, and has no new file, for `older_s` seconds. It is renamed before it
    is deleted, so that no other process sees a part of it; a process keeps the code it has loaded and compiles the
    rest again. If two processes remove at once, one of them finds nothing to rename.
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
    """Return the hash of every source file below `package` that contains kernels."""
    digest = hashlib.sha256()
    for path in sorted(package.rglob("*.py")):
        text = path.read_bytes()
        if _MARK.encode() in text:
            digest.update(path.relative_to(package).as_posix().encode() + b"\0" + text)
    return digest.hexdigest()[:16]
