"""OpenCV, 4.10 to 5, behind one door of this room."""

from __future__ import annotations

from typing import Any

from palpate.core import load_extra


def load() -> Any:
    """The library.

    Raises
    ------
    MissingExtraError
        If OpenCV is not installed.
    """
    return load_extra("cv2", "vision", "OpenCV")
