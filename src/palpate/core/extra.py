"""Optional libraries: loaded on use; the error contains the command that installs them."""

from __future__ import annotations

import importlib
from typing import Any

from palpate.core.errors import MissingExtraError, PalpateError


def load_extra(module: str, extra: str, library: str = "") -> Any:
    """Load an optional library.

    Parameters
    ----------
    module
        Name under which it is imported.
    extra
        The extra of this package that installs it.
    library
        Name for messages; by default `module`.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    PalpateError
        If it is installed, but lacks a library of the system, such as libGL.so.1.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        raise MissingExtraError(library or module, extra) from error
    except ImportError as error:
        if isinstance(error.__cause__ or error.__context__, KeyboardInterrupt):  # a compiled module wraps it
            raise KeyboardInterrupt from error
        raise PalpateError(
            f"{library or module} cannot be loaded: {error}.",
            "`palpate doctor --load` names the system package that it needs.",
            code="library-unloadable",
        ) from error


def load_opencv() -> Any:
    """Load OpenCV, 4.10 to 5.

    Raises
    ------
    MissingExtraError
        If it is not installed.
    """
    return load_extra("cv2", "vision", "OpenCV")
