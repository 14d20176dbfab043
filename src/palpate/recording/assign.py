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

ASSIGN_VERSION = "3"
"""Version of the code that decides which dot is which; part of an artefact's key."""
_SAID = 500
_LEAST_SURE, _LOOKED, _ALIKE, _TURNS = 30, 200, 8, 3
_MOTIONS, _ROUNDS, _ODD = 24, 4, 0.1
"""Motions of the sensor that are learnt, rounds of their robust fit, and how far from them dots may be on average,
over the spacing."""


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
    """Look again at images that are not sure, led by all that are; those that move as no sure image does are odd."""
    sure = [number for number, one in enumerate(found) if one.sure]
    if len(sure) < _LEAST_SURE:
        return
    seen = np.array([describe_dots(sight.dots[number], correspondent.shape) for number in sure])
    motions = _learn_motions(np.array([found[number].moved_px for number in sure]))
    spacing = float(np.median(correspondent.layout.spacing_px))
    usual = np.median([motions.miss(found[number]) for number in sure[:_LOOKED]]) / spacing
    for number, one in enumerate(found):
        if one.sure or not len(sight.dots[number]):
            continue
        likeness = seen @ describe_dots(sight.dots[number], correspondent.shape)
        alike = [sure[k] for k in np.argsort(-likeness)[:_ALIKE]]
        tries = [one, correspondent.find(sight.dots[number], tuple(found[k].moved_px for k in alike))]
        for _ in range(_TURNS):
            guess = motions.fit(max(tries, key=lambda each: each.score))
            tries.append(correspondent.refine(sight.dots[number], guess))
        best = max(tries, key=lambda each: (each.good, each.score - motions.miss(each) / spacing))
        if best.good and motions.miss(best) / spacing > max(_ODD, 5.0 * usual):
            best = Correspondence(best.moved_px, best.found, best.agreement, best.rough, Fault.ODD)
        found[number] = best


@dataclass(frozen=True, eq=False)
class _Motions:
    """How dots of a sensor move together: mean (2m,) and principal directions (2m, k), px."""

    mean: FloatArray
    directions: FloatArray

    def fit(self, one: Correspondence) -> FloatArray:
        """The motion (m, 2) of the sensor that is nearest to most of the assigned dots."""
        there = np.repeat(one.found, 2)
        basis, moved = self.directions[there], (one.moved_px.ravel() - self.mean)[there]
        weight = np.ones(len(moved))
        coordinates: FloatArray = np.zeros(basis.shape[1])
        for _ in range(_ROUNDS):
            part = basis * weight[:, None]
            hold = 1e-3 * np.eye(basis.shape[1])
            coordinates = np.asarray(np.linalg.solve(part.T @ basis + hold, part.T @ moved), float)
            off = np.linalg.norm((moved - basis @ coordinates).reshape(-1, 2), axis=1)
            weight = np.repeat(1.0 / (1.0 + (off / max(1.5 * float(np.median(off)), 0.3)) ** 2), 2)
        return np.asarray((self.mean + self.directions @ coordinates).reshape(-1, 2))

    def miss(self, one: Correspondence) -> float:
        """Root mean square distance of the assigned dots from such a motion, px."""
        off = (one.moved_px - self.fit(one))[one.found]
        return float(np.sqrt(np.mean((off**2).sum(axis=1)))) if len(off) else np.inf


def _learn_motions(fields: FloatArray) -> _Motions:
    flat = fields.reshape(len(fields), -1).astype(float)
    mean = flat.mean(axis=0)
    _, _, right = np.linalg.svd(flat - mean, full_matrices=False)
    return _Motions(mean, right[: min(_MOTIONS, len(fields) // 3)].T)
