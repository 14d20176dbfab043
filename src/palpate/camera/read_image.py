"""Image files: their size is read before their content, so that no file can fill the memory."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import PalpateError, load_extra, load_opencv

SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm", ".ppm", ".webp")
LARGEST_MPX = 40.0
"""Largest image that is read, in millions of pixels."""


def read_image(path: Path, largest_mpx: float = LARGEST_MPX) -> NDArray[Any]:
    """Read an image as it is.

    Parameters
    ----------
    path
        The file.
    largest_mpx
        Largest image that is read, in millions of pixels.

    Returns
    -------
    ndarray
        (h, w) or (h, w, 3), blue, green, red; 8 or 16 bit.

    Raises
    ------
    PalpateError
        If the file is missing, cut off, no image or too large.
    MissingExtraError
        If OpenCV or Pillow is not installed.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise PalpateError(
            f"{path.name} cannot be read: {error}.", "Check the file.", code="image-unreadable"
        ) from error
    return decode_image(content, path.name, largest_mpx)


def decode_image(content: bytes, name: str = "The image", largest_mpx: float = LARGEST_MPX) -> NDArray[Any]:
    """Decode the content of an image file, as `read_image` does.

    Parameters
    ----------
    content
        The file.
    name
        What it is called in errors.
    largest_mpx
        Largest image that is read, in millions of pixels.

    Raises
    ------
    PalpateError
        If it is cut off, no image or too large.
    MissingExtraError
        If OpenCV or Pillow is not installed.
    """
    width, height = _read_size(content, name)
    if width * height > largest_mpx * 1e6:
        raise PalpateError(
            f"{name} has {width} × {height} px, more than {largest_mpx:g} million.",
            "Shrink the image.",
            code="image-too-large",
        )
    cv2 = load_opencv()
    image = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_ANYCOLOR | cv2.IMREAD_ANYDEPTH)
    if image is None:
        raise PalpateError(
            f"{name} cannot be decoded: it is cut off or damaged.", "Save it again.", code="image-damaged"
        )
    return np.asarray(image)


def list_images(folder: Path) -> tuple[Path, ...]:
    """Image files of a folder by name.

    Raises
    ------
    PalpateError
        If it is no folder or has no image.
    """
    if not folder.is_dir():
        raise PalpateError(f"{folder} is not a folder.", "Give a folder of images.", code="folder-missing")
    found = tuple(sorted(path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES))
    if not found:
        raise PalpateError(f"{folder} has no image.", f"Known are {', '.join(SUFFIXES)}.", code="folder-no-image")
    return found


def _read_size(content: bytes, name: str) -> tuple[int, int]:
    Image = load_extra("PIL.Image", "vision", "Pillow")
    UnidentifiedImageError = load_extra("PIL", "vision", "Pillow").UnidentifiedImageError
    limit, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None  # our own limit gives a better message
    try:
        with Image.open(BytesIO(content)) as image:
            return int(image.size[0]), int(image.size[1])
    except UnidentifiedImageError as error:
        raise PalpateError(
            f"{name} is not an image.", f"Known are {', '.join(SUFFIXES)}.", code="image-format-unknown"
        ) from error
    except (OSError, ValueError, SyntaxError) as error:
        raise PalpateError(f"{name} cannot be read: {error}.", "Check the file.", code="image-unreadable") from error
    finally:
        Image.MAX_IMAGE_PIXELS = limit
