"""Images in one array: a file of numpy, (n, h, w), as a laboratory may have written it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import ClassVar

import numpy as np

from palpate.camera import Source
from palpate.core import PalpateError


class StackSource(Source):
    """A stack of images, read one by one."""

    suffixes: ClassVar[tuple[str, ...]] = (".npy",)

    def __init__(self, text: str) -> None:
        self._path = Path(text)
        try:
            self._stack = np.load(self._path, mmap_mode="r")
        except (OSError, ValueError) as error:
            raise PalpateError(
                f"{self._path.name} is no stack of images: {error}.", "Give a file .npy.", code="file-unreadable"
            ) from None

    @property
    def name(self) -> str:
        return self._path.name

    def images(self) -> Iterator[np.ndarray]:
        for image in self._stack:
            yield np.array(image)
