"""Sensor runtime: pose readings from images, by the processing chain that is used in simulation."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
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
"""Accepted blobs: minimum and maximum share of the markers, and number of false ones. By hand."""
_SPARE = 1.3
"""Factor on the widest gap of the design's image, as markers may be missing and the camera tilted.
By hand."""


@dataclass(frozen=True, eq=False)
class _State:
    """State carried from one image to the next: marker tracks and the estimator's state."""

    tracks: TrackState
    reader: ReaderState


@dataclass
class Sensor:
    """Sensor runtime, with the state after the last image.

    Attributes
    ----------
    unit, estimator, spec
        The unit, its pose estimator, and the thresholds of the flags.
    detector, assignment, registration
        Results of the rest image.
    clock
        Called once per image, before it is read, for its time in s. With it, forces follow the relaxation of the
        material, and camera drift is tracked in time. `None`: forces are those of the elastic law, and images follow
        each other at the nominal rate.
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
        """Drift of the markers since the rest images; `None` if the estimator does not track it."""
        rest = self._state.reader.rest
        return None if rest is None else rest.motion

    def fit_by(self, fitter: PoseFitter) -> None:
        """Use another fit of the unit's twin from the next image on, with a fresh fit state."""
        assert isinstance(self.estimator, TwinEstimator)
        self.estimator.fitter = fitter
        self._state = replace(self._state, reader=replace(self._state.reader, fit=FitState()))

    def read(self, image: NDArray[Any] | PalpateError) -> Reading:
        """Estimate the pose of the obstacle in the next image.

        An error in place of an image, and any error of reading it, give a flagged reading without a pose; the next
        image continues from the last good one.
        """
        start = time.perf_counter()
        self._count += 1
        try:
            reading = self._read(image)
        except Exception as error:  # a sensor at work outlives whatever one image does to a library
            space, reason = self.estimator.space, PalpateError.of(error).problem
            reading = Reading.without_pose(space, Flag.UNREADABLE, reason=reason)
        return replace(reading, image=self._count, latency_ms=(time.perf_counter() - start) * 1e3)

    def _read(self, image: NDArray[Any] | PalpateError) -> Reading:
        taken_s = None if self.clock is None else self.clock()
        elastic = self._read_elastic(image, taken_s)
        return elastic if self._fading is None or taken_s is None else self._fading.update(elastic, taken_s)

    def _read_elastic(self, image: NDArray[Any] | PalpateError, taken_s: float | None) -> Reading:
        """Return the reading with the force of the elastic law."""
        if isinstance(image, PalpateError):
            raise image
        blobs = self.detector.find(image)
        sighting, tracks = self._tracker.follow(blobs.positions_px, self._state.tracks)
        found = int(sighting.found.sum())
        if found < self.spec.min_found * len(self.unit.design.layout):
            self._state = replace(self._state, tracks=self._tracker.begin())  # the next is looked for from rest
            return Reading.without_pose(self.estimator.space, Flag.FEW_MARKERS, found)
        reading, self._state = self._estimate(blobs.positions_px, sighting, tracks, taken_s)
        assert reading.sighting is not None
        flags = [Flag.JUMPED] if reading.sighting.jumped else []
        flags += [flag for flag in reading.flags if reading.touching or flag is Flag.CAMERA_MOVED]
        return replace(reading, found=found, flags=tuple(flags))

    def _estimate(
        self, blobs_px: FloatArray, sighting: TrackedMarkers, tracks: TrackState, taken_s: float | None
    ) -> tuple[Reading, _State]:
        """Return the reading with its marker positions, and the state after this image.

        If markers jumped or the fit has a misfit, they are assigned again by the fit's predicted positions. The new
        assignment is used if its misfit is not larger. Both fits start from the state after the previous image.
        """
        estimate, reader = self.estimator.estimate(sighting, self._state.reader, time_s=taken_s)
        first = replace(estimate, sighting=sighting), _State(tracks, reader)
        if not sighting.jumped and Flag.MISFIT not in estimate.flags:
            return first
        foreseen = self.estimator.predict_markers(estimate)
        if foreseen is None or estimate.fit is None:
            return first
        named, tracks = self._tracker.reassign(
            blobs_px, np.where(np.isfinite(foreseen), foreseen, sighting.positions_px)
        )
        if np.array_equal(named.blob, sighting.blob):  # the fit foresees what was seen: no marker jumped
            return replace(estimate, sighting=named), _State(tracks, reader)
        again, reader = self.estimator.estimate(named, self._state.reader, estimate, taken_s)
        if again.fit is not None and again.fit.misfit <= estimate.fit.misfit:
            return replace(again, sighting=named), _State(tracks, reader)
        return first


@dataclass(frozen=True, eq=False)
class RestReference:
    """Result of the rest images: detector, marker assignment and camera registration.

    `unit` is the given unit with its lens scaled to the images.
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
    """Detect and assign the markers of the unloaded skin, and register the camera.

    Parameters
    ----------
    images
        One or more rest images of one size; marker positions are averaged over them.
    unit
        The sensor.
    detect
        Settings of the detection; `None` determines them from the first image.
    reference_press
        Press of known pose that resolves an ambiguous assignment.
    refine_lens
        Whether focal length and centre are fitted as well (`palpate.vision.register`).

    Raises
    ------
    PalpateError
        If there is no image, the blobs do not match the design, or their assignment is ambiguous.
    """
    images = list(images)
    if not images:
        raise PalpateError(
            "No rest image was given.",
            "Record at least one image of the unloaded sensor first; in a table of images, its press is 'rest'.",
            code="rest-image-missing",
        )
    height, width = np.asarray(images[0]).shape[:2]
    unit = unit.at_size(width, height)
    mark = place_orientation_mark(unit.design.skin, unit.design.layout) if unit.has_orientation_mark else None
    pattern = build_pattern(unit.design.layout.positions, build_camera(unit.camera_spec).project, mark)
    with _name_image(1, len(images)):
        detector, naming = _find_and_name(images[0], unit, detect, pattern)
    if naming.ambiguous and reference_press is not None:
        naming = disambiguate(
            naming, detector.find(reference_press.image).positions_px, reference_press.positions, unit
        ).naming
        if naming.ambiguous:
            raise PalpateError(
                f"The reference press leaves {1 + len(naming.alternatives)} possible assignments of the markers.",
                "Press with a wall tilted by 5° or more, at an azimuth of 15° from a row of markers.",
                code="assignment-ambiguous",
            )
    elif unit.has_orientation_mark and naming.ambiguous:
        raise PalpateError(
            f"The orientation mark was not found; {1 + len(naming.alternatives)} assignments of the markers fit.",
            "Check that it is printed and lit, give a reference press, or declare the unit as one without a mark.",
            code="orientation-mark-unseen",
        )
    naming = _average(naming, detector, images)
    where = register_dome(naming, unit.design.layout, unit.design.skin, unit.camera_spec, refine_lens)
    return RestReference(unit, detector, naming, where)


@contextmanager
def _name_image(number: int, count: int) -> Iterator[None]:
    """Give an error the number of the rest image in which it occurs, if there are several."""
    try:
        yield
    except PalpateError as error:
        if count > 1:
            error.problem = f"{error.problem.rstrip('.')} (rest image {number} of {count})."
            error.args = (f"{error.problem} {error.remedy}".strip(),)
        raise


def _find_and_name(
    image: NDArray[Any], unit: Unit, detect: DetectSpec | None, pattern: MarkerPattern
) -> tuple[Detector, MarkerAssignment]:
    """Return a detector with settings from the image alone, and the assignment of its blobs.

    If the markers are lost in clutter, so that this fails, the marker size of the design is used.
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
    """Open a sensor by its rest images.

    Parameters
    ----------
    rest
        One or more rest images of one size.
    unit, model
        The sensor, and its model: a trained network, or the twin of its design.
    spec, detect
        Thresholds of the flags, and settings of the detection.
    reference_press
        Press of known pose that resolves an ambiguous assignment.

    Raises
    ------
    PalpateError
        If the model is of another design, or `analyse_rest` fails.
    """
    check_model(model, unit)
    spec = spec or SensorSpec()
    seen = analyse_rest(rest, unit, detect, reference_press, spec.refine_lens)
    reader = make_estimator(model, seen.unit, seen.naming, seen.registration, spec)
    return Sensor(seen.unit, reader, spec, seen.detector, seen.naming, seen.registration)


def run_sensor(
    sensor: Sensor | RecordedModel, images: Iterable[NDArray[Any] | PalpateError], spec: SensorSpec | None = None
) -> Iterator[Reading]:
    """Return one reading per image; an unreadable image gives a flagged reading.

    A `RecordedModel` needs no rest image and takes its flag thresholds from `spec`; a `Sensor` ignores `spec`.
    """
    reads = RecordedSensor(sensor, spec) if isinstance(sensor, RecordedModel) else sensor
    return (reads.read(image) for image in images)


def _average(naming: MarkerAssignment, detector: Detector, images: list[NDArray[Any]]) -> MarkerAssignment:
    """Return the assignment with positions averaged over all rest images."""
    if len(images) == 1:
        return naming
    tracker = Tracker(MotionModel(naming.positions_px))
    seen = []
    for number, image in enumerate(images, start=1):
        with _name_image(number, len(images)):
            seen.append(tracker.step(detector.find(image).positions_px))
    positions = np.mean([sighting.positions_px for sighting in seen], axis=0)
    found = np.mean([sighting.found for sighting in seen], axis=0) > 0.5
    return replace(naming, positions_px=positions, found=found)
