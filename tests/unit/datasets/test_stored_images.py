"""Images in arrays: which arrays hold them, and that every row is its own image."""

import numpy as np
import pytest

from needs import needs
from palpate.datasets.stored_images import holds_images, read_row


def drawn(level: int) -> np.ndarray:
    """Image (8, 10) whose pixels all have one grey level."""
    return np.full((8, 10), level, np.uint8)


def files(levels: list[int], kind: str) -> np.ndarray:
    """PNG files of `drawn`: objects of bytes, or rows of bytes filled with zeros to one length."""
    cv2 = needs("cv2")
    parts = [cv2.imencode(".png", drawn(level))[1].tobytes() for level in levels]
    if kind == "objects":
        found = np.empty(len(parts), object)
        found[:] = parts
        return found
    return np.array([np.frombuffer(part.ljust(256, b"\0"), np.uint8) for part in parts])


@pytest.mark.parametrize("kind", ["objects", "bytes"])
def test_files_are_told_by_the_first_row_and_each_row_is_its_own_image(kind: str) -> None:
    stored = files([40, 90, 200], kind)
    assert holds_images(stored)
    assert holds_images(stored[:1])
    for row, level in enumerate((40, 90, 200)):
        assert np.array_equal(np.squeeze(read_row(stored, row)), drawn(level))
    stored[0] = b"nothing" if kind == "objects" else 7
    assert not holds_images(stored)


@pytest.mark.parametrize("shape", [(3, 8, 10), (3, 8, 10, 3), (3, 3, 8, 10), (3, 8, 10, 1), (1, 8, 8)])
def test_each_row_of_pixels_is_its_own_image_with_channels_last(shape: tuple[int, ...]) -> None:
    stored = np.random.default_rng(0).integers(0, 256, shape).astype(np.uint8)
    assert holds_images(stored)
    for row, image in enumerate(stored):
        channels_first = len(shape) == 4 and shape[1] == 3
        assert np.array_equal(read_row(stored, row), np.moveaxis(image, 0, -1) if channels_first else image)


@pytest.mark.parametrize("shape", [(3, 7, 10), (3, 8, 7), (3, 8, 10, 2), (3, 7, 8, 3), (0, 8, 10), (3,), (3, 64)])
def test_shorter_sides_and_other_channels_are_no_images(shape: tuple[int, ...]) -> None:
    assert not holds_images(np.zeros(shape, np.uint8))


def test_grey_levels_of_fractions_end_at_one_and_of_integers_at_sixteen_bits() -> None:
    fractions, integers = np.zeros((2, 8, 8)), np.zeros((2, 8, 8), np.int32)
    fractions[0, 0, 0], integers[0, 0, 0] = 1.0, 65535
    assert holds_images(fractions)
    assert holds_images(integers)
    assert not holds_images(fractions * 1.1)
    assert not holds_images(integers + 1)
    assert not holds_images(-fractions)
