"""Compiled kernels: one typed door to numba, with the machine code kept on disk."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile `function` by numba to a disk cache; floating point may be re-associated, never made unsafe.

    NaN and infinity keep their meaning, so an inverted element can be seen.
    """
    import numba  # here, so that a front door without kernels opens fast

    compiled = numba.njit(cache=True, nogil=True, fastmath={"reassoc", "contract", "arcp", "nsz"})(function)
    return cast(F, compiled)
