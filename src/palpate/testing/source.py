"""Contract suite of sources of images."""

from __future__ import annotations

import numpy as np
import pytest

from palpate.camera import SOURCES, Source, open_source
from palpate.core import PalpateError


class SourceSuite:
    """Inherit and give the fixtures `text` and `missing`; pytest collects the rest."""

    @pytest.fixture
    def text(self) -> str:
        """Text that names a source with a few images and an end."""
        raise NotImplementedError("Give the fixture `text`.")

    @pytest.fixture
    def missing(self) -> str:
        """Text that names a missing source of the same kind."""
        raise NotImplementedError("Give the fixture `missing`.")

    @pytest.fixture
    def kind(self, text: str) -> type[Source]:
        """The class that opens the text."""
        with open_source(text) as source:
            return type(source)

    def test_it_is_found_by_its_name_and_knows_its_text(self, kind: type[Source], text: str) -> None:
        name = next(name for name, other in SOURCES.available() if other is kind)
        assert kind.accepts(text)
        with open_source(f"{name}:{text}") as source:
            assert type(source) is kind

    def test_no_other_source_takes_its_text(self, kind: type[Source], text: str) -> None:
        assert [other for _, other in SOURCES.available() if other.accepts(text)] == [kind]

    def test_it_has_a_name_that_a_person_reads(self, text: str) -> None:
        with open_source(text) as source:
            assert source.name.strip()

    def test_it_gives_images_or_errors_and_ends(self, text: str) -> None:
        with open_source(text) as source:
            items = list(source.images())
        images = [item for item in items if not isinstance(item, PalpateError)]
        assert images
        for image in images:
            assert image.ndim == 2 or (image.ndim == 3 and image.shape[2] == 3)
            assert image.dtype in (np.uint8, np.uint16)
        assert all(item.problem for item in items if isinstance(item, PalpateError))

    def test_images_that_were_given_do_not_change(self, text: str) -> None:
        with open_source(text) as source:
            kept = [(item, item.copy()) for item in source.images() if not isinstance(item, PalpateError)]
        assert all(np.array_equal(image, copy) for image, copy in kept)

    def test_it_may_be_closed_twice_and_before_its_end(self, text: str) -> None:
        with open_source(text) as source:
            next(source.images())
            source.close()

    def test_what_is_not_there_is_refused_with_a_remedy(self, kind: type[Source], missing: str) -> None:
        assert kind.accepts(missing) or not kind.suffixes
        with pytest.raises(PalpateError) as refused:
            open_source(missing)
        assert refused.value.remedy

    def test_endings_are_small_letters_with_a_dot(self, kind: type[Source]) -> None:
        assert all(suffix.startswith(".") and suffix == suffix.lower() for suffix in kind.suffixes)
