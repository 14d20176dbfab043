"""Assignment of all images of a recording to one layout: reference image, correspondences, faults."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from palpate.core import BoolArray, FloatArray, PalpateError, TextArray
from palpate.core.run import Progress
from palpate.vision.match_markers import Correspondence, MarkerMatcher, marker_descriptor
from palpate.vision.motion import fit_motion_model
from palpate.vision.observed_layout import LEAST_DOTS, ObservedLayout, number_markers

_REPORTED = 500
"""Number of images between two reports of progress."""
_PILOT, _TEACH, _LEAST_TAUGHT, _ALIKE = 300, (0.3, 0.5, 0.6), 15, 3
"""Number of images for the fit of motions, shares fitted per round, and their minimum number.

The last value is the number of similar images whose displacements are tried as guesses. By hand.
"""


_NOISE = 0.02
"""Minimum noise of a marker position, over the spacing. By hand."""
_PLAIN = 0.9
"""Share of confident images with a smooth field alone, from which no motions are fitted. By hand."""


@dataclass(frozen=True, eq=False)
class AssignedMarkers:
    """Markers of all images by index.

    Attributes
    ----------
    layout
        Markers at rest.
    reference
        Index of the image that gave the layout.
    moved_px
        (n, m, 2) displacement from rest, single precision; smooth if no blob was assigned.
    found
        (n, m) whether a blob was assigned.
    agreement, rough
        (n,) see `palpate.vision.match_markers.Correspondence`.
    faults
        (n,) reason to reject an image's correspondence; empty if accepted.
    motion
        (1 + k, 2m) mean and modes of the sensor's motion, see `palpate.vision.MotionModel`; empty if not fitted.
    usual
        (3,) agreement and roughness of confident images, and the noise of a motion, px.
    """

    layout: ObservedLayout
    reference: int
    moved_px: FloatArray
    found: BoolArray
    agreement: FloatArray
    rough: FloatArray
    faults: TextArray
    motion: FloatArray
    usual: FloatArray

    @property
    def good(self) -> BoolArray:
        """Whether the correspondence of each image (n,) is accepted."""
        return np.asarray(self.faults == "")

    @property
    def counts(self) -> dict[str, int]:
        """Number of images by fault; the empty fault counts accepted images."""
        return dict(Counter(self.faults.tolist()))


def choose_reference(blobs: Sequence[FloatArray], count: int) -> int:
    """Return the image whose blobs give the layout: the first rest image, else the most typical one.

    The first `count` images, with blobs (n, 2) px, are of presses, the following ones rest images. The most typical
    image has at least the usual number of blobs, and its blobs are distributed like the mean of all images.
    """
    if len(blobs) > count and len(blobs[count]) >= LEAST_DOTS:
        return count
    numbers = np.array([len(each) for each in blobs[:count]])
    usual = float(np.median(numbers))
    if usual < LEAST_DOTS:
        raise PalpateError(
            f"Half of the images show fewer than {LEAST_DOTS} blobs.",
            "Train on pixels alone: --estimators picture.",
            code="markers-few",
        )
    width, height = np.max([each.max(axis=0) for each in blobs[:count] if len(each)], axis=0) + 1.0
    seen = np.array([marker_descriptor(each, (height, width)) for each in blobs[:count]])
    likeness = seen @ seen[numbers > 0].mean(axis=0)
    return int(np.argmax(np.where(numbers >= np.quantile(numbers, 0.7), likeness, -1.0)))


def assign_images(
    blobs: Sequence[FloatArray], reference: int, shape: tuple[int, int], smooth: bool, progress: Progress
) -> AssignedMarkers:
    """Find the correspondence of every image, with blobs (n, 2) px, to the layout of the reference image.

    `shape` is the height and width of the images, px; for `smooth` see `palpate.vision.match_markers.MarkerMatcher`.
    """
    layout = number_markers(blobs[reference])
    correspondent = MarkerMatcher(layout, shape, smooth=smooth)
    if smooth:
        _learn_motions(blobs, correspondent, progress)
    total, what = len(blobs), "correspondence"
    progress.plan(total)
    progress.begin(what, total)
    found: list[Correspondence] = []
    for number, seen in enumerate(blobs):
        found.append(correspondent.find(seen))
        correspondent.remember(seen, found[-1])
        if (number + 1) % _REPORTED == 0:
            rejected = sum(not one.accepted for one in found)
            progress.advance(what, number + 1, f"{number + 1} of {total} images, {rejected} rejected")
    progress.finish(what)
    return AssignedMarkers(
        layout,
        reference,
        np.array([one.moved_px for one in found], np.float32),
        np.array([one.found for one in found]),
        np.array([one.agreement for one in found]),
        np.array([one.rough for one in found]),
        np.array([str(one.fault) for one in found]),
        *correspondent.to_arrays(),
    )


def _learn_motions(blobs: Sequence[FloatArray], correspondent: MarkerMatcher, progress: Progress) -> None:
    """Fit the sensor's modes of motion, in rounds: fit to the best images, then assign all of them again.

    They are dropped if fewer images are accepted than by a smooth field.
    """
    some = np.unique(np.linspace(0, len(blobs) - 1, min(_PILOT, len(blobs))).astype(int))
    some = some[[len(blobs[number]) >= LEAST_DOTS for number in some]]
    found = []
    for number in some:
        found.append(correspondent.find(blobs[number]))
        correspondent.remember(blobs[number], found[-1])
    if np.mean([one.confident for one in found]) >= _PLAIN:
        return  # a smooth field tells such a sensor's dots, and does not believe what it has not seen elsewhere
    plain, accepted = replace(correspondent), sum(one.accepted for one in found)
    seen = np.array([marker_descriptor(blobs[number], correspondent.shape) for number in some])
    spacing = float(np.median(correspondent.layout.spacing_px))
    for share in _TEACH:
        order = np.argsort([-one.score for one in found])
        taught = order[: max(int(share * len(found)), sum(one.confident for one in found))]
        if len(taught) < _LEAST_TAUGHT:
            return
        correspondent.motions = fit_motion_model(
            correspondent.layout.rest_px, [found[k].moved_px for k in taught], _NOISE * spacing
        )
        correspondent.fields = [found[k].moved_px for k in taught]
        correspondent.seen = list(seen[taught])
        for k, number in enumerate(some):
            alike = taught[np.argsort(-(seen[taught] @ seen[k]))[:_ALIKE]]
            guesses = [found[k].moved_px, *(found[other].moved_px for other in alike if other != k)]
            tries = [correspondent.refine(blobs[number], guess) for guess in guesses]
            found[k] = max(tries, key=lambda one: one.score)
        best = [found[k] for k in taught]
        correspondent.usual = (
            min(correspondent.usual[0], float(np.quantile([one.agreement for one in best], 0.3))),
            max(correspondent.usual[1], float(np.quantile([one.rough for one in best], 0.7))),
        )
    if sum(one.accepted for one in found) < accepted:  # too few images for all motions of this sensor
        for name in ("motions", "fields", "seen", "usual"):
            setattr(correspondent, name, getattr(plain, name))
        return
    progress.note(f"motions of the sensor: fitted to {len(taught)} images")
