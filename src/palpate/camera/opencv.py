"""OpenCV, 4.10 to 5, behind one door of this room."""

from __future__ import annotations

from typing import Any

from palpate.core import MissingExtraError


def load() -> Any:
    """The library.

    Raises
    ------
    MissingExtraError
        If OpenCV is not installed.
    """
    try:
        import cv2
    except ImportError as error:
        raise MissingExtraError("OpenCV", "vision") from error
    return cv2
