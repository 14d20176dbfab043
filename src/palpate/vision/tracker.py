"""Marker tracking through a press: assignment of the blobs of each image to markers.

Every marker is extrapolated from its last two images. If predictions do not coincide with blobs already, they are
moved by the joint correction of markers that agree with their neighbours. Then the assignment of minimum squared
distance is made. A marker without a blob is estimated by the motion model from those with one.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree

from palpate.core import BoolArray, FloatArray, PalpateError
from palpate.vision.assign_markers import MarkerAssignment
from palpate.vision.detector import Detector
from palpate.vision.motion import MotionModel
from palpate.vision.neighbours import agree, nearest, nearest_distance
from palpate.vision.segment import Blobs

REACH = 0.45
"""Maximum distance of a blob from its prediction, over the distance to the nearest other marker.
By hand."""
_JUMP = 0.25
"""Median distance of blobs from predictions, over the spacing, of a jump of the markers. By hand."""
_SURE, _SURE_SHARE = 0.2, 0.9
"""Predictions need no correction if the second share of them has a blob within the first of a spacing.
By hand."""
_ROUGH = 0.6
"""Roughness of the motion above which two markers have changed places, as they differ by a spacing.
By hand."""
_ALONE_PX, _LEAST_ROOM_PX = 50.0, 2.0
"""Bounds of the distance to the nearest other marker. By hand."""
_ROUNDS, _NEIGHBOURS = 3, 7
"""Rounds of the joint correction, and number of markers that determine it. By hand."""


@dataclass(frozen=True, eq=False)
class TrackedMarkers:
    """All markers in one image.

    Attributes
    ----------
    positions_px
        (m, 2) column and row; estimated by the motion model if no blob was found.
    found
        (m,) whether a blob was found.
    blob
        (m,) index of the blob, -1 without one.
    jumped
        Whether the markers moved further than the prediction allows: a snap, a lost image or another sensor.
    """

    positions_px: FloatArray
    found: BoolArray
    blob: NDArray[np.intp]
    jumped: bool


@dataclass(frozen=True, eq=False)
class Tracks:
    """All markers through a sequence of images; for the attributes of one image see `TrackedMarkers`.

    `positions_px` is (n, m, 2), `found` (n, m) and `jumped` (n,).
    """

    positions_px: FloatArray
    found: BoolArray
    jumped: BoolArray

    def __len__(self) -> int:
        return len(self.positions_px)


@dataclass(frozen=True, eq=False)
class TrackState:
    """Markers (m, 2) px in the last two images, from which those of the next image are predicted."""

    before_px: FloatArray
    last_px: FloatArray


@dataclass
class Tracker:
    """Tracker of markers from image to image.

    Attributes
    ----------
    motion
        Model of the joint motion; its rest positions are those of the assignment.
    state
        State after the last image of `step`; `follow` and `reassign` do not change it.
    """

    motion: MotionModel

    def __post_init__(self) -> None:
        if len(self.motion.rest_px) < 1:
            raise PalpateError(
                "There is no marker to track.",
                "Assign the markers of a rest image first.",
                code="tracker-no-marker",
            )
        self.state = self.begin()
        self._near = (
            cKDTree(self.motion.rest_px)
            .query(self.motion.rest_px, min(_NEIGHBOURS, len(self.motion.rest_px)))[1]
            .reshape(len(self.motion.rest_px), -1)
        )
        self._space = _room(self.motion.rest_px)

    def begin(self) -> TrackState:
        """Return the state before any image: all markers at rest."""
        return TrackState(self.motion.rest_px, self.motion.rest_px)

    def step(self, blobs_px: FloatArray) -> TrackedMarkers:
        """Assign the blobs (n, 2) of the next image, and update the state."""
        sighting, self.state = self.follow(blobs_px, self.state)
        return sighting

    def follow(self, blobs_px: FloatArray, state: TrackState) -> tuple[TrackedMarkers, TrackState]:
        """Assign the blobs (n, 2) of the image after a state; return the markers and the next state."""
        blobs_px = np.asarray(blobs_px, float).reshape(-1, 2)
        predicted = 2.0 * state.last_px - state.before_px
        if not len(blobs_px):
            nowhere = np.zeros(len(predicted), bool), np.full(len(predicted), -1)
            return TrackedMarkers(state.last_px, *nowhere, True), state
        blobs_px = np.ascontiguousarray(blobs_px)
        positions, blob, offset = self._try(predicted, blobs_px)
        if offset > _SURE or np.mean(blob >= 0) < _SURE_SHARE or self._roughness(positions) > _ROUGH:
            # this may be a release, or the image before was wrong: look from standstill and from rest as well
            tries = [self._try(start, blobs_px) for start in (state.last_px, self.motion.rest_px)]
            positions, blob, offset = min(
                [(positions, blob, offset), *tries], key=lambda seen: self._roughness(seen[0]) - np.mean(seen[1] >= 0)
            )
        found = blob >= 0
        jumped = bool(offset > _JUMP or found.mean() < 0.5 or self._roughness(positions) > _ROUGH)
        before = positions if jumped else state.last_px  # after a jump there is no motion to go on with
        return TrackedMarkers(positions, found, blob, jumped), TrackState(before, positions)

    def reassign(self, blobs_px: FloatArray, predicted_px: FloatArray) -> tuple[TrackedMarkers, TrackState]:
        """Assign the blobs (n, 2) of an image near predicted places (m, 2); return markers and next state.

        The roughness of the motion is not tested.
        """
        positions, blob, offset = self._try(predicted_px, np.ascontiguousarray(blobs_px))
        found = blob >= 0
        jumped = bool(offset > _JUMP or found.mean() < 0.5)
        return TrackedMarkers(positions, found, blob, jumped), TrackState(positions, positions)

    def _try(self, predicted: FloatArray, blobs_px: FloatArray) -> tuple[FloatArray, NDArray[np.intp], float]:
        """Return positions and blobs of all markers from one prediction, and its error over the spacing."""
        space, (number, distance) = _room(predicted), nearest(predicted, blobs_px)
        near = np.bincount(number, minlength=len(blobs_px))
        if np.mean(distance < _SURE * space) > _SURE_SHARE and np.count_nonzero(near) > _SURE_SHARE * len(number):
            offset = float(np.median(distance / space))
        else:
            agreed = agree(predicted, blobs_px, self._near, 0.6 * space, _ROUNDS)
            offset = float(np.median(np.linalg.norm(agreed - predicted, axis=1) / space))
            predicted, space, (number, distance) = agreed, _room(agreed), nearest(agreed, blobs_px)
        blob = _assign(predicted, blobs_px, REACH * space, np.where(distance < REACH * space, number, -1))
        found = blob >= 0
        positions = np.where(found[:, None], blobs_px[blob], predicted)
        if found.any() and not found.all():
            positions = np.where(found[:, None], positions, self.motion.fill(positions, found))
        return positions, blob, offset

    def _roughness(self, positions: FloatArray) -> float:
        """Return the maximum difference of a marker's motion from its neighbours' mean, over the spacing."""
        if len(positions) < _NEIGHBOURS:
            return 0.0
        moved = positions - self.motion.rest_px
        own = np.linalg.norm(moved - moved[self._near[:, 1:]].mean(axis=1), axis=1)
        return float(np.max(own / self._space))


def _room(places: FloatArray) -> FloatArray:
    return np.maximum(nearest_distance(places, _ALONE_PX), _LEAST_ROOM_PX)


def _assign(
    predicted: FloatArray, blobs: FloatArray, reach: FloatArray, nearest_one: NDArray[np.intp]
) -> NDArray[np.intp]:
    """Return the nearest blobs within reach (m,), or a minimum-squared-distance assignment on conflict."""
    wanted = nearest_one[nearest_one >= 0]
    if not len(wanted) or np.bincount(wanted).max() < 2:
        return nearest_one
    limit = reach[:, None] ** 2
    square = np.minimum(((predicted[:, None] - blobs[None]) ** 2).sum(axis=-1), limit)
    marker, blob = linear_sum_assignment(square)
    result = np.full(len(predicted), -1)
    result[marker] = np.where(square[marker, blob] < limit[marker, 0], blob, -1)
    return result


def find_markers(
    images: Iterable[NDArray[Any]], detector: Detector, naming: MarkerAssignment, motion: MotionModel | None = None
) -> Tracks:
    """Find and track all markers through images that begin near rest, from their assignment at rest.

    `motion` is the model of the joint motion; by default any smooth one.
    """
    tracker = Tracker(motion or MotionModel(naming.positions_px))
    seen = [tracker.step(_centres(detector.find(image))) for image in images]
    markers = len(naming.positions_px)
    return Tracks(
        positions_px=np.array([sighting.positions_px for sighting in seen]).reshape(-1, markers, 2),
        found=np.array([sighting.found for sighting in seen], bool).reshape(-1, markers),
        jumped=np.array([sighting.jumped for sighting in seen], bool),
    )


def _centres(blobs: Blobs) -> FloatArray:
    return blobs.positions_px
