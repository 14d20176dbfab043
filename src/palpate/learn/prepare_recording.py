"""Preparation of a recording for training: blobs, small images, correspondence and split."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.core import ArtefactStore, BoolArray, FloatArray, PalpateError, Recipe, stage_version
from palpate.core.named_arrays import read_arrays, write_arrays
from palpate.core.run import Progress
from palpate.datasets import LEAST_PRESSES, PressSplit, Recording, split_presses
from palpate.learn.gaussian_process import choose_symmetry
from palpate.learn.preprocess import Detections, Preprocessor, choose_preprocessor, first_duplicate, preprocess_images
from palpate.learn.recording_spec import RecordingSpec
from palpate.learn.rotation import RotationAugmentation, find_rotation
from palpate.learn.training_set import TrainingSet
from palpate.vision import AssignedMarkers, ObservedLayout, assign_images, choose_reference

_LEAST_GOOD = 0.25
"""Minimum share of images with assigned markers for estimators on markers. By hand."""
_FIELD = 6
"""Number of blobs in an image from which they form a field. By hand."""


@dataclass(frozen=True, eq=False)
class PreparedRecording:
    """Prepared recording, without unreadable and duplicate images.

    Attributes
    ----------
    recording, eye, sight, assigned
        The recording, its preprocessing, the detections, and the assigned markers (`None` without markers).
    rows
        (n,) rows of the recording that are used.
    moved, accepted
        (n, m, 2) displacements and (n,) whether their assignment is accepted; empty without markers.
    pictures, targets, press
        (n, h, w), (n, k) and (n,).
    split
        Training, validation and test presses.
    notes
        Notes on the recording, for the report.
    """

    recording: Recording
    eye: Preprocessor
    sight: Detections
    assigned: AssignedMarkers | None
    rows: NDArray[Any]
    moved: FloatArray
    accepted: BoolArray
    pictures: NDArray[np.uint8]
    targets: FloatArray
    press: NDArray[Any]
    split: PressSplit
    notes: tuple[str, ...]

    @cached_property
    def rotation(self) -> RotationAugmentation | None:
        """Rotation of (rx, ry) with the training images; `None` without markers, or if none fits."""
        if self.assigned is None:
            return None
        rows, axes = self.accepted & self.split.train, [one.axis for one in self.recording.poses]
        at_rest = self.assigned.reference >= len(self.recording)
        found = find_rotation(self.assigned.layout.rest_px, self.moved[rows], self.targets[rows], axes, at_rest)
        samples, _ = self.samples(True)
        return choose_symmetry(replace(samples, rotation=found))

    def samples(self, markers: bool, seed: int = 0) -> tuple[TrainingSet, BoolArray]:
        """Accepted displacements, or all images, as training samples; and (n,) the test samples."""
        rows = self.accepted if markers else np.ones(len(self.targets), bool)
        inputs, split = self.moved if markers else self.pictures, self.split
        train, validation = split.train & rows, split.validation & rows
        return TrainingSet(inputs, self.targets, train, validation, seed, press=self.press), split.test & rows


def prepare_recording(
    recording: Recording, spec: RecordingSpec, store: ArtefactStore, progress: Progress
) -> PreparedRecording:
    """Prepare a recording: blobs and small images, correspondence, split.

    Raises
    ------
    PalpateError
        If its images cannot be read, or too few are left.
    """
    eye = choose_preprocessor(recording, spec.picture_px)
    notes = list(recording.notes)
    if spec.estimators == "picture":
        eye = replace(eye, detector=None, dark=False)
    sight = preprocess_images(recording, eye, store, progress)
    count = len(recording)
    assigned, told = _assign(recording, eye, sight, spec, store, progress)
    notes += told
    kept = sight.readable[:count].copy()
    if not kept.all():
        broken = int(np.argmin(kept))
        notes.append(
            f"{int((~kept).sum())} images cannot be read, the first is {recording.names[broken]}: "
            f"{sight.faults[broken]}"
        )
    first = first_duplicate(sight.digests[:count])
    double, apart = kept & (first != np.arange(count)), np.abs(recording.targets - recording.targets[first])
    if double.any():
        off = ", ".join(
            f"{one.axis} {apart[double, k].max():.3g} {one.unit}" for k, one in enumerate(recording.poses)
        )
        notes.append(
            f"{int(double.sum())} images are copies of others and left out; their poses differ by up to {off}."
        )
    rows = np.flatnonzero(kept & ~double)
    press = recording.press[rows]
    if len(np.unique(press)) < LEAST_PRESSES:
        raise PalpateError(
            f"{len(rows)} different images of {len(np.unique(press))} presses are left of {count}: too few to learn "
            "from.",
            " ".join(notes[-2:]),
            code="recording-few-left",
        )
    good = np.zeros(len(rows), bool) if assigned is None else assigned.good[:count][rows]
    moved: FloatArray = np.zeros((len(rows), 0, 2)) if assigned is None else assigned.moved_px[:count][rows]
    split = split_presses(press, spec.seed, spec.validation_share, spec.test_share)
    pictures = sight.pictures[:count][rows]
    return PreparedRecording(
        recording,
        eye,
        sight,
        assigned,
        rows,
        moved,
        good,
        pictures,
        recording.targets[rows],
        press,
        split,
        tuple(notes),
    )


def _assign(
    recording: Recording,
    eye: Preprocessor,
    sight: Detections,
    spec: RecordingSpec,
    store: ArtefactStore,
    progress: Progress,
) -> tuple[AssignedMarkers | None, list[str]]:
    """Assigned markers of all images (`None` if there are too few), and notes on them."""
    notes: list[str] = []
    count = len(recording)
    if spec.estimators == "picture":
        return None, notes
    without = sum(len(dots) < _FIELD for dots in sight.blobs[:count])
    if eye.detector is None or without > 0.8 * count:
        notes.append(f"{without} of {count} images show no field of markers: only image estimators are trained.")
        return None, notes
    if without > 0.02 * count:
        notes.append(f"{without} of {count} images show no markers.")
    reference = choose_reference(sight.blobs, count)
    if reference < count:
        notes.append(
            f"No image is at rest; {recording.names[reference]}, the most central one, gives the layout "
            f"({len(sight.blobs[reference])} dots)."
        )
    digest = hashlib.sha256(b"".join(np.ascontiguousarray(dots).tobytes() for dots in sight.blobs)).hexdigest()
    recipe = Recipe(
        "assigned", [digest, reference, spec.correspondence, list(eye.shape)], version=stage_version("correspondence")
    )
    path = store.find(recipe)
    if path is None:
        found = assign_images(sight.blobs, reference, eye.shape, spec.correspondence == "grown", progress)
        own = {key: value for key, value in vars(found).items() if key not in ("layout", "reference")}
        path = store.write(recipe, lambda file: write_arrays(file, {"rest_px": found.layout.rest_px, **own}))
    arrays = read_arrays(path)
    assigned = AssignedMarkers(ObservedLayout(arrays.pop("rest_px")), reference, **arrays)
    failed = int((~assigned.good[:count]).sum())
    notes.append(
        f"{len(assigned.layout)} markers form the layout; the assignment of {count - failed} of {count} images is "
        f"accepted{'; the remaining images are read by an image estimator' if failed else ''}."
    )
    if failed > (1 - _LEAST_GOOD) * count:
        notes.append("Too few for estimators on markers: only image estimators are trained.")
        return None, notes
    return assigned, notes
