"""Reading of image files; the size is checked before decoding, so that no file exhausts the memory.

Pixels are those of the sensor: a camera's EXIF orientation is ignored, since a lens belongs to the sensor's pixels.
A Bayer mosaic is developed to its green channel (`develop_mosaic`).
"""

from __future__ import annotations

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import PalpateError, load_extra, load_opencv
from palpate.core.files import natural_key

SUFFIXES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".pgm", ".ppm", ".webp")
LARGEST_MPX = 40.0
"""Maximum size of an image, in millions of pixels. By hand."""
_MOSAIC, _PART, _SHARE = 0.08, 8, 0.9
"""Criteria of a mosaic: minimum difference of colours, and share of image parts with the same sign.

The difference is relative; a part has 16 × 16 px. In grey images both signs are equally frequent.
"""


def read_image(path: Path, largest_mpx: float = LARGEST_MPX) -> NDArray[Any]:
    """Read an image without change, except for a mosaic.

    Parameters
    ----------
    path
        The file.
    largest_mpx
        Maximum size of the image, in millions of pixels.

    Returns
    -------
    ndarray
        (h, w) or (h, w, 3), blue, green, red; 8 or 16 bit, or float.

    Raises
    ------
    PalpateError
        If the file is missing, cut off, not an image or too large.
    MissingExtraError
        If OpenCV or Pillow is not installed.
    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise PalpateError(
            f"{path.name} cannot be read: {error.strerror}.", "Give an image.", code="image-unreadable"
        ) from error
    return decode_image(content, path.name, largest_mpx)


def decode_image(content: bytes, name: str = "The image", largest_mpx: float = LARGEST_MPX) -> NDArray[Any]:
    """Decode the content of an image file, as `read_image` does; `name` is used in errors.

    Raises
    ------
    PalpateError
        If it is cut off, not an image or too large.
    MissingExtraError
        If OpenCV or Pillow is not installed.
    """
    width, height = _read_size(content, name)
    if width * height > largest_mpx * 1e6:
        raise PalpateError(
            f"{name} has {width} × {height} px, more than {largest_mpx:g} million.",
            "Reduce the size of the image.",
            code="image-too-large",
        )
    cv2 = load_opencv()
    flags = cv2.IMREAD_ANYCOLOR | cv2.IMREAD_ANYDEPTH | cv2.IMREAD_IGNORE_ORIENTATION
    try:
        image = cv2.imdecode(np.frombuffer(content, np.uint8), flags)
    except cv2.error:
        image = None
    if image is None:
        raise PalpateError(
            f"{name} cannot be decoded: it is cut off or damaged.", "Save it again.", code="image-damaged"
        )
    return develop_mosaic(np.asarray(image))


def develop_mosaic(image: NDArray[Any]) -> NDArray[Any]:
    """Develop a Bayer mosaic saved as grey to its green channel; return any other image unchanged.

    A mosaic is recognised by the four pixels of each 2 × 2 block: two on a diagonal are equal (green), and one of the
    second diagonal is darker, or brighter, than these by more than `_MOSAIC` and in nearly all lit parts of the
    image.
    """
    if image.ndim != 2 or image.dtype not in (np.uint8, np.uint16) or min(image.shape) < 2 * _PART:
        return image
    rows, columns = (side // (2 * _PART) for side in image.shape)
    parts = image[: rows * 2 * _PART, : columns * 2 * _PART].reshape(rows, _PART, 2, columns, _PART, 2)
    means = parts.mean(axis=(1, 4), dtype=float).transpose(1, 3, 0, 2).reshape(4, -1)
    means = means[:, means.mean(axis=0) > 0.5 * means.mean()]
    pairs = ((means[0], means[3], means[1], means[2]), (means[1], means[2], means[0], means[3]))
    for number, (first, second, *others) in enumerate(pairs):
        green = (first + second) / 2.0
        alike = green.size and abs(np.median((first - second) / green)) < 0.25 * _MOSAIC
        differ = [(other - green) / green for other in others]
        if alike and any(
            abs(np.median(one)) > _MOSAIC and max(np.mean(one > 0), np.mean(one < 0)) > _SHARE for one in differ
        ):
            cv2 = load_opencv()
            order = (cv2.COLOR_BayerGB2BGR, cv2.COLOR_BayerBG2BGR)[number]
            return np.ascontiguousarray(cv2.cvtColor(image, order)[..., 1])
    return image


def list_images(folder: Path) -> tuple[Path, ...]:
    """Return the image files of a folder by name, numbers in natural order.

    Raises
    ------
    PalpateError
        If it is not a folder or has no image.
    """
    if not folder.is_dir():
        raise PalpateError(f"{folder} is not a folder.", "Give a folder of images.", code="folder-missing")
    images = (path for path in folder.iterdir() if path.suffix.lower() in SUFFIXES and not path.name.startswith("."))
    found = tuple(sorted(images, key=lambda path: natural_key(path.name)))
    if not found:
        raise PalpateError(
            f"{folder} contains no image.", f"Supported formats: {', '.join(SUFFIXES)}.", code="folder-no-image"
        )
    return found


def _read_size(content: bytes, name: str) -> tuple[int, int]:
    Image = load_extra("PIL.Image", "vision", "Pillow")
    UnidentifiedImageError = load_extra("PIL", "vision", "Pillow").UnidentifiedImageError
    limit, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None  # our own limit gives a better message
    try:
        with Image.open(BytesIO(content)) as image:
            size, pages = (int(image.size[0]), int(image.size[1])), int(getattr(image, "n_frames", 1))
            if pages > 1:  # pages of other sizes are previews
                image.seek(1)
            if pages > 1 and image.size == size:
                raise PalpateError(
                    f"{name} is a stack of {pages} images.", "Save each as a file of its own.", code="image-stack"
                )
            return size
    except PalpateError:
        raise
    except UnidentifiedImageError as error:
        raise PalpateError(
            f"{name} is not an image.", f"Supported formats: {', '.join(SUFFIXES)}.", code="image-format-unknown"
        ) from error
    except Exception as error:  # a damaged page ends the decoders by errors of every kind
        raise PalpateError(f"{name} cannot be read: {error}.", "Check the file.", code="image-unreadable") from error
    finally:
        Image.MAX_IMAGE_PIXELS = limit
