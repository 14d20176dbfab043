"""Blobs and a small copy of every image of a recording; nothing larger is kept in memory.

Images are processed in chunks. The result of a chunk is in the store under the stamps of its files, so that an
interrupted run processes no image twice.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.camera import LARGEST_MPX
from palpate.core import (
    ArtefactStore,
    BoolArray,
    FloatArray,
    IntArray,
    MissingExtraError,
    PalpateError,
    Recipe,
    TextArray,
    load_opencv,
    stage_version,
)
from palpate.core.named_arrays import read_arrays, write_arrays
from palpate.core.run import Progress
from palpate.datasets import Recording
from palpate.vision import Detector, DetectSpec, prepare_detector

CHUNK = 200
"""Images read at a time, limited by memory. By hand."""
_LOOKED = 7
"""Number of images, evenly spaced, in which markers are sought if there is no rest image. By hand."""

Pictures = NDArray[np.uint8]


@dataclass(frozen=True, eq=False)
class Preprocessor:
    """Preprocessing of images, chosen once from a few images of a recording.

    Attributes
    ----------
    shape
        Height and width of the images, px.
    detector
        Detector of blobs; `None` if no image has a field of markers.
    size
        Height and width of the small images, px.
    dark
        Whether markers are darker than their surroundings; small images are inverted so that markers are bright.
    """

    shape: tuple[int, int]
    detector: Detector | None
    size: tuple[int, int]
    dark: bool

    def extract(self, image: NDArray[Any]) -> tuple[Pictures, FloatArray]:
        """Return the small image (h, w) and the blobs (n, 2) of an image.

        Raises
        ------
        PalpateError
            If it is not an image, or has another size.
        """
        grey = _grey(image)
        if grey.shape != self.shape:
            raise PalpateError(
                f"An image has {grey.shape[1]} × {grey.shape[0]} px, others {self.shape[1]} × {self.shape[0]}.",
                "Give images of one size.",
                code="image-size-changed",
            )
        cv2 = load_opencv()
        small = cv2.resize(grey, self.size[::-1], interpolation=cv2.INTER_AREA)
        if self.detector is None:
            return small, np.zeros((0, 2))
        try:
            dots = self.detector.find(grey).positions_px
        except PalpateError:
            dots = np.zeros((0, 2))
        return 255 - small if self.dark else small, dots


@dataclass(frozen=True, eq=False)
class Detections:
    """Detections in all images.

    Attributes
    ----------
    pictures
        (n, h, w) small images, markers bright.
    blobs
        n arrays (k, 2) of blobs, px.
    digests
        (n,) checksum of each image's pixels.
    faults
        (n,) reason why an image could not be read; empty for readable ones.
    """

    pictures: Pictures
    blobs: tuple[FloatArray, ...]
    digests: TextArray
    faults: TextArray

    @property
    def readable(self) -> BoolArray:
        """(n,) whether an image could be read."""
        return np.asarray(self.faults == "")


def choose_preprocessor(recording: Recording, picture_px: int) -> Preprocessor:
    """Choose polarity and size of the blobs, and the size of small images, from a few images.

    Raises
    ------
    PalpateError
        If none of them can be read.
    """
    count = len(recording)
    looked = (
        range(count, count + recording.rest) if recording.rest else np.linspace(0, count - 1, _LOOKED).astype(int)
    )
    items = list(recording.images.read(sorted({int(k) for k in looked})))
    images = [_grey(item) for item in items if not isinstance(item, PalpateError)]
    if not images:
        for item in items:
            if isinstance(item, MissingExtraError):
                raise item
        reason = next((item.problem for item in items if isinstance(item, PalpateError)), "it has no images")
        raise PalpateError(
            f"The first images cannot be read: {reason}", "Check the table's image names.", code="images-unreadable"
        )
    shape = images[0].shape
    size = tuple(max(8, round(side * picture_px / max(shape))) for side in shape)
    found = []
    for image in images:
        try:
            detector = prepare_detector(image, DetectSpec(mask="none"))
            found.append((len(detector.find(image)), detector))
        except PalpateError:
            continue
    if not found:
        return Preprocessor(shape, None, (size[0], size[1]), False)
    detector = sorted(found, key=lambda pair: pair[0])[len(found) // 2][1]
    return Preprocessor(shape, detector, (size[0], size[1]), detector.dark)


def preprocess_images(
    recording: Recording, eye: Preprocessor, store: ArtefactStore, progress: Progress
) -> Detections:
    """Preprocess all images of a recording, rest images last.

    Raises
    ------
    PalpateError
        If none can be read, or the store cannot be written.
    """
    total, parts = len(recording) + recording.rest, []
    spec = [list(eye.shape), list(eye.size), eye.dark, None if eye.detector is None else _describe(eye.detector)]
    planned = False
    for start in range(0, total, CHUNK):
        numbers = range(start, min(start + CHUNK, total))
        stamps = hashlib.sha256("\n".join(recording.images.stamp(number) for number in numbers).encode()).hexdigest()
        recipe = Recipe("sight", [stamps, spec], version=stage_version("detections"))
        path = store.find(recipe)
        if path is None:
            if not planned:  # an interrupted run has left the first of them
                progress.plan(total - start)
                planned = True
            what = f"markers of images {numbers[0] + 1} to {numbers[-1] + 1} of {total}"
            progress.begin(what, len(numbers))
            path = store.write(recipe, lambda file, own=numbers: _write(file, recording, eye, own))  # type: ignore[misc]
            progress.finish(what)
        parts.append(read_arrays(path))
    ends = np.concatenate([part["count"] for part in parts])
    dots = np.concatenate([part["dots"] for part in parts])
    sight = Detections(
        np.concatenate([part["pictures"] for part in parts]),
        tuple(np.split(dots, np.cumsum(ends)[:-1])),
        np.concatenate([part["digests"] for part in parts]),
        np.concatenate([part["faults"] for part in parts]),
    )
    if not sight.readable.any():
        raise PalpateError(f"No image can be read: {sight.faults[0]}", "Check the images.", code="images-unreadable")
    return sight


def _write(path: Path, recording: Recording, eye: Preprocessor, numbers: Sequence[int]) -> None:
    pictures, dots, digests, faults = [], [], [], []
    for item in recording.images.read(numbers):
        try:
            if isinstance(item, PalpateError):
                raise item
            picture, places = eye.extract(item)
            digests.append(hashlib.sha256(np.ascontiguousarray(item).tobytes()).hexdigest()[:16])
            faults.append("")
        except PalpateError as error:
            picture, places = np.zeros(eye.size, np.uint8), np.zeros((0, 2))
            digests.append("")
            faults.append(error.problem[:200])
        pictures.append(picture)
        dots.append(places)
    arrays = {
        "pictures": np.stack(pictures),
        "dots": np.concatenate(dots),
        "count": np.array([len(one) for one in dots]),
        "digests": np.array(digests, "U16"),
        "faults": np.array(faults, "U200"),
    }
    write_arrays(path, arrays)


def first_duplicate(digests: TextArray) -> IntArray:
    """(n,) number of the first image with the same pixels, which may be the image itself."""
    _, first, number = np.unique(digests, return_index=True, return_inverse=True)
    found = np.asarray(first[number.reshape(-1)])
    return np.where(digests == "", np.arange(len(digests)), found)


def _describe(detector: Detector) -> list[float]:
    return [detector.dark, round(detector.diameter_px, 4), round(detector.edge_px, 4), detector.drop_strays]


def _grey(image: NDArray[Any]) -> Pictures:
    """Grey levels (h, w) of 8 bit of any image."""
    image = np.asarray(image)
    if image.ndim not in (2, 3) or (image.ndim == 3 and image.shape[2] not in (1, 3, 4)):
        raise PalpateError(
            f"An array of shape {image.shape} is not an image.", "Give (h, w) or (h, w, 3).", code="image-shape-wrong"
        )
    if image.shape[0] * image.shape[1] > LARGEST_MPX * 1e6 or min(image.shape[:2]) < 8:
        raise PalpateError(
            f"An image has {image.shape[1]} × {image.shape[0]} px.",
            "Give 8 px a side to 40 million.",
            code="image-size-out-of-bounds",
        )
    top = _white_level(image)
    if image.ndim == 3:
        image = image[..., 0] if image.shape[2] == 1 else image[..., :3].astype(np.float32) @ _LUMA
    if image.dtype != np.uint8:
        image = np.clip(np.nan_to_num(image.astype(np.float32)) * (255.0 / top), 0, 255).astype(np.uint8)
    if image.max() == 1:
        image = image * np.uint8(255)  # black and white kept as 0 and 1
    return np.ascontiguousarray(image)


def _white_level(image: NDArray[Any]) -> float:
    """White level: 1 of fractions, 255 of 8 bit, 4095 of 10 and 12 bit, 65535 of 16 bit.

    10 and 12 bit share a level, so that a brighter image of a camera of 10 bit does not change its scale.
    """
    if image.dtype == np.uint8:
        return 255.0
    most = float(np.nan_to_num(image.max(initial=0)))
    if image.dtype.kind != "u":
        return next((level for level in (1.0, 255.0, 4095.0) if most <= level), 65535.0)
    return 4095.0 if most <= 4095.0 else 65535.0


_LUMA = np.array([0.114, 0.587, 0.299], np.float32)
"""Weights of blue, green and red (ITU-R BT.601)."""
