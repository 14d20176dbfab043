"""All images of a recording by the numbers of one layout: reference, correspondence, and what became of each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from palpate.core import BoolArray, FloatArray, PalpateError, TextArray
from palpate.recording.correspond import Correspondence, Correspondent, Fault, describe_dots
from palpate.recording.layout import LEAST_DOTS, DotLayout, number_dots
from palpate.recording.sight import Sight

ASSIGN_VERSION = "1"
"""Version of the code that decides which dot is which; part of an artefact's key."""
_SAID = 500


@dataclass(frozen=True, eq=False)
class Assigned:
    """Dots of all images by number.

    Attributes
    ----------
    layout
        Dots at rest.
    reference
        Number of the image that the layout was read from.
    moved_px
        (n, m, 2) displacement from rest, single precision; smooth where no dot was found.
    found
        (n, m) whether a dot was assigned.
    agreement, rough
        (n,) see `palpate.recording.correspond.Correspondence`.
    faults
        (n,) why an image's correspondence is not believed; empty for those that are.
    """

    layout: DotLayout
    reference: int
    moved_px: FloatArray
    found: BoolArray
    agreement: FloatArray
    rough: FloatArray
    faults: TextArray

    @property
    def good(self) -> BoolArray:
        """(n,) whether the correspondence of an image is believed."""
        return np.asarray(self.faults == "")

    @property
    def counts(self) -> dict[str, int]:
        """Number of images by what became of them; empty for those that are believed."""
        return dict(Counter(self.faults.tolist()))


def choose_reference(sight: Sight, count: int) -> int:
    """The image whose dots give the layout: the first at rest, else the most central one.

    The most central image has as many dots as most images, and looks most like the mean of where dots are.

    Parameters
    ----------
    sight
        What is seen; images at rest come after `count` others.
    count
        Number of images of presses.
    """
    if len(sight.dots) > count and len(sight.dots[count]) >= LEAST_DOTS:
        return count
    numbers = np.array([len(dots) for dots in sight.dots[:count]])
    usual = float(np.median(numbers))
    if usual < LEAST_DOTS:
        raise PalpateError(
            f"Half of the images show fewer than {LEAST_DOTS} dots.",
            "Learn from pictures alone: --estimators picture.",
        )
    shape = (sight.pictures.shape[1], sight.pictures.shape[2])
    most = np.max([dots.max(axis=0) for dots in sight.dots[:count] if len(dots)], axis=0)
    scale = np.array(shape[::-1]) / np.maximum(most + 1.0, 1.0)
    seen = np.array([describe_dots(dots * scale, shape) for dots in sight.dots[:count]])
    likeness = seen @ seen[numbers > 0].mean(axis=0)
    return int(np.argmax(np.where(numbers >= np.quantile(numbers, 0.7), likeness, -1.0)))


def assign_images(
    sight: Sight, reference: int, shape: tuple[int, int], smooth: bool, say: Callable[[str], None]
) -> Assigned:
    """Find the correspondence of every image; images that fail are tried again when all others are known.

    Parameters
    ----------
    sight, reference
        What is seen, and the image that gives the layout.
    shape
        Height and width of the images, px.
    smooth
        See `palpate.recording.correspond.Correspondent`.
    say
        Told how far it is.
    """
    layout = number_dots(sight.dots[reference])
    correspondent = Correspondent(layout, shape, smooth=smooth)
    total = len(sight.dots)
    found: list[Correspondence] = []
    for number, dots in enumerate(sight.dots):
        found.append(correspondent.find(dots))
        correspondent.remember(dots, found[-1])
        if (number + 1) % _SAID == 0:
            say(f"correspondence: {number + 1} of {total} images, {sum(not one.good for one in found)} not believed")
    if smooth:
        _try_again(sight, correspondent, found)
    return Assigned(
        layout,
        reference,
        np.array([one.moved_px for one in found], np.float32),
        np.array([one.found for one in found]),
        np.array([one.agreement for one in found]),
        np.array([one.rough for one in found]),
        np.array([str(one.fault) for one in found]),
    )


def _try_again(sight: Sight, correspondent: Correspondent, found: list[Correspondence]) -> None:
    """Look again at images that are not sure, with all others as guesses; drop those that agree with none alike."""
    sure = [number for number, one in enumerate(found) if one.sure]
    if len(sure) < 10:
        return
    seen = np.array([describe_dots(sight.dots[number], correspondent.shape) for number in sure])
    spacing = float(np.median(correspondent.layout.spacing_px))
    for number, one in enumerate(found):
        if one.sure or not len(sight.dots[number]):
            continue
        likeness = seen @ describe_dots(sight.dots[number], correspondent.shape)
        alike = [sure[k] for k in np.argsort(-likeness)[:8] if sure[k] != number]
        again = correspondent.find(sight.dots[number], tuple(found[k].moved_px for k in alike))
        best = max((one, again), key=lambda each: (each.good, each.score))
        apart = [np.median(np.linalg.norm(best.moved_px - found[k].moved_px, axis=1)) for k in alike]
        if best.good and min(apart) > 1.5 * spacing:
            best = Correspondence(best.moved_px, best.found, best.agreement, best.rough, Fault.ODD)
        found[number] = best
