"""Image files of a folder."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import final

from palpate.camera.read_image import list_images, read_image
from palpate.camera.source import ImageOrError, Source
from palpate.core import PalpateError


@final
class FolderSource(Source):
    """Image files of a folder by name; files that are added later are ignored."""

    def __init__(self, text: str) -> None:
        self._folder = Path(text)
        self._paths = list_images(self._folder)

    @classmethod
    def accepts(cls, text: str) -> bool:
        return Path(text).is_dir()

    @property
    def name(self) -> str:
        return str(self._folder)

    def images(self) -> Iterator[ImageOrError]:
        for path in self._paths:
            try:
                yield read_image(path)
            except PalpateError as error:
                yield error
