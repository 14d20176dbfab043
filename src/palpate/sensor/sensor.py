"""The sensor: from images to readings, by the same detector, numbers, tracks and model as in simulation."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.calibration import FitState, PoseFitter
from palpate.camera import build_camera
from palpate.core import FloatArray, PalpateError
from palpate.design import place_orientation_mark
from palpate.learn import RecordedModel
from palpate.sensor.force_relaxation import ForceRelaxation
from palpate.sensor.pose_estimator import (
    PoseEstimate,
    PoseEstimator,
    PoseModel,
    ReaderState,
    TwinEstimator,
    check_model,
    make_estimator,
)
from palpate.sensor.reading import Flag, Reading
from palpate.sensor.recorded_sensor import RecordedSensor
from palpate.sensor.reference_press import ReferencePress, disambiguate
from palpate.sensor.rest_drift import RestDrift
from palpate.sensor.spec import SensorSpec
from palpate.sensor.unit import Unit
from palpate.vision import (
    Detector,
    DetectSpec,
    MarkerAssignment,
    MarkerPattern,
    MotionModel,
    Registration,
    TrackedMarkers,
    Tracker,
    TrackState,
    assign_markers,
    build_pattern,
    prepare_detector,
    register_dome,
)

_FOUND, _DIRT = (0.8, 1.5), 10
"""Least and greatest number of dots, over the design's, with which a size that the design gives is believed; and how
many more there may be of what is no dot."""
_SPARE = 1.3
"""By what gaps in a field may be wider than in the design's image: dots are missing, cameras stand askew."""


@dataclass(frozen=True, eq=False)
class _State:
    """What a sensor carries from one image to the next: where the markers were, and what its reader carries."""

    tracks: TrackState
    reader: ReaderState


@dataclass
class Sensor:
    """A sensor at work; it remembers where the markers were, and what its reader knew, after the last image.

    Attributes
    ----------
    unit, estimator, spec
        What it is, what it estimates with, and when it flags.
    detector, assignment, registration
        What the rest image gave.
    clock
        Asked once an image, before it is read: when it was taken, in s. With it, forces are those of that time where
        the material relaxes, and a drift of the camera is followed in time; `None`: forces are those of the law's
        constants, and images follow each other at the nominal rate.
    """

    unit: Unit
    estimator: PoseEstimator
    spec: SensorSpec
    detector: Detector
    assignment: MarkerAssignment
    registration: Registration
    clock: Callable[[], float] | None = None

    def __post_init__(self) -> None:
        relaxation = self.estimator.relaxation
        self._fading = ForceRelaxation(relaxation) if relaxation is not None else None
        self._tracker = Tracker(MotionModel(self.assignment.positions_px))
        self._state = _State(self._tracker.begin(), self.estimator.begin())
        self._count = 0

    @property
    def rest(self) -> RestDrift | None:
        """How far the untouched dots have drifted; `None` where nothing looks."""
        rest = self._state.reader.rest
        return None if rest is None else rest.motion

    def fit_by(self, fitter: PoseFitter) -> None:
        """Read by another fit of the unit's twin from the next image on, as one that has fitted none."""
        assert isinstance(self.estimator, TwinEstimator)
        self.estimator.fitter = fitter
        self._state = replace(self._state, reader=replace(self._state.reader, fit=FitState()))

    def read(self, image: NDArray[Any] | PalpateError) -> Reading:
        """Estimate the pose of the wall in the next image; an error instead of an image gives a flagged reading.

        So does any error that reading an image meets: the next one is read from where the last good one was.
        """
        start = time.perf_counter()
        self._count += 1
        try:
            return self._read(image, start)
        except Exception as error:  # a sensor at work outlives whatever one image does to a library
            return self._without_pose(start, 0, (Flag.UNREADABLE,), PalpateError.of(error).problem)

    def _read(self, image: NDArray[Any] | PalpateError, start: float) -> Reading:
        taken_s = None if self.clock is None else self.clock()
        elastic = self._read_elastic(image, start, taken_s)
        return elastic if self._fading is None or taken_s is None else self._fading.update(elastic, taken_s)

    def _read_elastic(self, image: NDArray[Any] | PalpateError, start: float, taken_s: float | None) -> Reading:
        """The reading with the force that the law alone gives."""
        if isinstance(image, PalpateError):
            raise image
        blobs = self.detector.find(image)
        sighting, tracks = self._tracker.follow(blobs.positions_px, self._state.tracks)
        found = int(sighting.found.sum())
        if found < self.spec.min_found * len(self.unit.design.layout):
            self._state = replace(self._state, tracks=self._tracker.begin())  # the next is looked for from rest
            return self._without_pose(start, found, (Flag.FEW_MARKERS,), "")
        sighting, estimate, state = self._estimate(blobs.positions_px, sighting, tracks, taken_s)
        touching = estimate.moved_px > self.spec.touch_px
        flags = [Flag.JUMPED] if sighting.jumped else []
        flags += [
            flag for flag in estimate.flags if touching or flag is Flag.CAMERA_MOVED
        ]  # at rest no pose is outside
        reading = Reading(
            image=self._count,
            pose=tuple(estimate.pose.tolist()),
            half_width=tuple(estimate.half_width.tolist()),
            touching=touching,
            found=found,
            flags=tuple(flags),
            latency_ms=(time.perf_counter() - start) * 1e3,
            sighting=sighting,
            space=self.estimator.space,
            force=estimate.force,
            fit=estimate.fit,
            rest=estimate.rest,
        )
        self._state = state
        return reading

    def _estimate(
        self, blobs_px: FloatArray, sighting: TrackedMarkers, tracks: TrackState, taken_s: float | None
    ) -> tuple[TrackedMarkers, PoseEstimate, _State]:
        """Where markers are, the estimate, and the state after this image.

        Where markers jumped or the estimate does not explain them, they are named anew by it, if that explains more;
        both readings begin from the state after the image before.
        """
        estimate, reader = self.estimator.estimate(sighting, self._state.reader, time_s=taken_s)
        first = sighting, estimate, _State(tracks, reader)
        if not sighting.jumped and Flag.MISFIT not in estimate.flags:
            return first
        foreseen = self.estimator.predict_markers(estimate)
        if foreseen is None or estimate.fit is None:
            return first
        named, tracks = self._tracker.reassign(
            blobs_px, np.where(np.isfinite(foreseen), foreseen, sighting.positions_px)
        )
        if np.array_equal(named.blob, sighting.blob):  # the fit foresees what was seen: no marker jumped
            return named, estimate, _State(tracks, reader)
        again, reader = self.estimator.estimate(named, self._state.reader, estimate, taken_s)
        if again.fit is not None and again.fit.misfit <= estimate.fit.misfit:
            return named, again, _State(tracks, reader)
        return first

    def _without_pose(self, start: float, found: int, flags: tuple[Flag, ...], reason: str) -> Reading:
        space, latency = self.estimator.space, (time.perf_counter() - start) * 1e3
        none, anything = (float("nan"),) * len(space.names), (float("inf"),) * len(space.names)
        return Reading(self._count, none, anything, False, found, flags, latency, reason, space=space)


@dataclass(frozen=True, eq=False)
class RestReference:
    """What images of the untouched dome give: how its dots are found, which marker each is, where the camera is.

    The unit is the given one with its lens scaled to the images.
    """

    unit: Unit
    detector: Detector
    naming: MarkerAssignment
    registration: Registration


def analyse_rest(
    images: Iterable[NDArray[Any]],
    unit: Unit,
    detect: DetectSpec | None = None,
    reference_press: ReferencePress | None = None,
    refine_lens: bool = False,
) -> RestReference:
    """Find and name the dots of the untouched dome, and register the camera.

    Parameters
    ----------
    images
        One or more images at rest, of one size; places are averaged over them.
    unit
        The sensor.
    detect
        How to find dots.
    reference_press
        A press that tells the numbers where the mark does not.
    refine_lens
        Whether focal length and centre are fitted as well (`palpate.vision.register`).

    Raises
    ------
    PalpateError
        If the dots are not those of the design, or their names are ambiguous.
    """
    images = list(images)
    if not images:
        raise PalpateError(
            "No image shows the unloaded skin.",
            "Record one first; in a table of images, its press is 'rest'.",
            code="rest-image-missing",
        )
    height, width = np.asarray(images[0]).shape[:2]
    unit = unit.at_size(width, height)
    mark = place_orientation_mark(unit.design.skin, unit.design.layout) if unit.has_orientation_mark else None
    pattern = build_pattern(unit.design.layout.positions, build_camera(unit.camera_spec).project, mark)
    detector, naming = _find_and_name(images[0], unit, detect, pattern)
    if naming.ambiguous and reference_press is not None:
        naming = disambiguate(
            naming, detector.find(reference_press.image).positions_px, reference_press.positions, unit
        ).naming
        if naming.ambiguous:
            raise PalpateError(
                f"The known press leaves {1 + len(naming.alternatives)} ways to number the markers.",
                "Press by a wall slanted by 5° or more, towards 15° from a row of markers.",
                code="assignment-ambiguous",
            )
    elif unit.has_orientation_mark and naming.ambiguous:
        raise PalpateError(
            f"The orientation mark was not seen; {1 + len(naming.alternatives)} ways to number the markers fit.",
            "Check that it is printed and lit, give an image of a known press, or say that the unit has no mark.",
            code="orientation-mark-unseen",
        )
    naming = _average(naming, detector, images)
    where = register_dome(naming, unit.design.layout, unit.design.skin, unit.camera_spec, refine_lens)
    return RestReference(unit, detector, naming, where)


def _find_and_name(
    image: NDArray[Any], unit: Unit, detect: DetectSpec | None, pattern: MarkerPattern
) -> tuple[Detector, MarkerAssignment]:
    """A detector by the image alone, and the names of its dots.

    Where few dots are lost in clutter, so that none or others are found, by the size that the design gives them.
    """
    gap = _SPARE * pattern.widest_gap
    try:
        detector = prepare_detector(image, detect, doubt=False, gap=gap)  # naming holds the dots against the design
        return detector, assign_markers(detector.find(image).positions_px, pattern)
    except PalpateError:
        camera = unit.camera_spec
        if detect is not None:
            raise
        away = camera.distance + float(np.median(unit.design.layout.positions[:, 2]))
        size = camera.fx_px * unit.design.layout.diameter / away
        for spec in (DetectSpec(polarity="dark", diameter_px=size), DetectSpec(polarity="bright", diameter_px=size)):
            with suppress(PalpateError):
                detector = prepare_detector(image, spec, doubt=False, gap=gap)
                found = detector.find(image).positions_px
                if _FOUND[0] * len(unit.design.layout) <= len(found) <= _FOUND[1] * len(unit.design.layout) + _DIRT:
                    return detector, assign_markers(found, pattern)
        raise


def open_sensor(
    rest: Iterable[NDArray[Any]],
    unit: Unit,
    model: PoseModel,
    spec: SensorSpec | None = None,
    detect: DetectSpec | None = None,
    reference_press: ReferencePress | None = None,
) -> Sensor:
    """Begin with images of the untouched dome.

    Parameters
    ----------
    rest
        One or more images at rest, of one size.
    unit, model
        The sensor, and what it reads with: a trained network, or the twin of its design.
    spec, detect
        When to flag, and how to find dots.
    reference_press
        A press that tells the numbers where the mark does not.

    Raises
    ------
    PalpateError
        If the model is that of another design, or where `analyse_rest` fails.
    """
    check_model(model, unit)
    spec = spec or SensorSpec()
    seen = analyse_rest(rest, unit, detect, reference_press, spec.refine_lens)
    reader = make_estimator(model, seen.unit, seen.naming, seen.registration, spec)
    return Sensor(seen.unit, reader, spec, seen.detector, seen.naming, seen.registration)


def run_sensor(
    sensor: Sensor | RecordedModel, images: Iterable[NDArray[Any] | PalpateError], spec: SensorSpec | None = None
) -> Iterator[Reading]:
    """Readings of images one by one; what cannot be read gives a flagged reading and the next is tried.

    The model of a recording is a sensor by itself: it knows its own rest, and takes when to flag from `spec`.
    """
    reads = RecordedSensor(sensor, spec) if isinstance(sensor, RecordedModel) else sensor
    return (reads.read(image) for image in images)


def _average(naming: MarkerAssignment, detector: Detector, images: list[NDArray[Any]]) -> MarkerAssignment:
    """The same naming with positions averaged over all rest images."""
    if len(images) == 1:
        return naming
    tracker = Tracker(MotionModel(naming.positions_px))
    seen = [tracker.step(detector.find(image).positions_px) for image in images]
    positions = np.mean([sighting.positions_px for sighting in seen], axis=0)
    found = np.mean([sighting.found for sighting in seen], axis=0) > 0.5
    return replace(naming, positions_px=positions, found=found)
