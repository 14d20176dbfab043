"""The sensor: from images to readings, by the same detector, numbers, tracks and model as in simulation.

The model was trained for the nominal camera. A dot seen by the real one is carried over the ray to the height of its
marker at rest, or to the wall where that is lower, and projected by the nominal camera; the same is done with the
rest image, and the model reads its own rest plus the difference. So roll, tilt, focal length and distortion of the
real camera are taken out exactly, print and seating errors at rest vanish, and an offset is taken out as far as the
dome follows the wall. The wall is that of a first estimate; of another obstacle only the heights at rest are used.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.camera import build_camera
from palpate.core import FloatArray, PalpateError
from palpate.design import MarkerLayout, PoseSpace, Skin, place_orientation_mark, wall_normal
from palpate.learn import Predictor
from palpate.markers import (
    Detector,
    DetectSpec,
    Motion,
    Naming,
    Tracker,
    build_pattern,
    name_markers,
    prepare_detector,
)
from palpate.sensor.known_press import KnownPress, ask_press
from palpate.sensor.reading import Flag, Reading
from palpate.sensor.register import Registration, register_dome
from palpate.sensor.spec import RigSpec
from palpate.sensor.unit import Unit

_SAME_MM = 0.1
"""Offset of the camera below which the height of a marker does not matter: below 0.1 px at full depth."""


@dataclass
class Sensor:
    """A sensor at work; it remembers where the markers were.

    Attributes
    ----------
    unit, predictor, spec
        What it is, what it estimates with, and when it flags.
    detector, naming, registration
        What the rest image gave.
    """

    unit: Unit
    predictor: Predictor
    spec: RigSpec
    detector: Detector
    naming: Naming
    registration: Registration

    def __post_init__(self) -> None:
        self._nominal = build_camera(self.unit.nominal)
        self._rest_model = self._nominal.project(self.unit.layout.positions)
        self._rest = self._carry(self._look(self.naming.positions_px))
        self._tracker = Tracker(Motion(self.naming.positions_px))
        self._count = 0
        here, there = self.registration.camera, self._nominal
        self._same = bool(np.linalg.norm(here.origin - there.origin) < _SAME_MM)

    def read(self, image: NDArray[Any] | PalpateError) -> Reading:
        """Estimate the pose of the wall in the next image; an error instead of an image gives a flagged reading."""
        start = time.perf_counter()
        self._count += 1
        try:
            if isinstance(image, PalpateError):
                raise image
            blobs = self.detector.find(image)
        except PalpateError as error:
            return self._without_pose(start, 0, (Flag.UNREADABLE,), error.what)
        sighting = self._tracker.step(blobs.positions_px)
        found = int(sighting.found.sum())
        if found < self.spec.least_found * len(self.unit.layout):
            self._tracker = Tracker(Motion(self.naming.positions_px))  # what follows is looked for from rest again
            return self._without_pose(start, found, (Flag.FEW_MARKERS,), "")
        rays = self._look(sighting.positions_px)
        moved = self._carry(rays) - self._rest
        prediction = self.predictor.predict((self._rest_model + moved)[None])
        if not self._same and self.predictor.space.tilts:
            # now that the wall is about known, so is how far the markers sank
            moved = self._carry(rays, prediction.poses[0]) - self._rest
            prediction = self.predictor.predict((self._rest_model + moved)[None])
        touching = bool(np.sqrt(np.mean(moved**2)) > self.spec.touch_px)
        flags = [Flag.JUMPED] if sighting.jumped else []
        flags += (
            [Flag.OUTSIDE] if touching and prediction.outside[0] else []
        )  # at rest there is no pose to be outside
        return Reading(
            image=self._count,
            pose=tuple(prediction.poses[0].tolist()),
            half_width=tuple(prediction.half_width[0].tolist()),
            touching=touching,
            found=found,
            flags=tuple(flags),
            latency_ms=(time.perf_counter() - start) * 1e3,
            sighting=sighting,
            space=self.predictor.space,
        )

    def _without_pose(self, start: float, found: int, flags: tuple[Flag, ...], reason: str) -> Reading:
        space, latency = self.predictor.space, (time.perf_counter() - start) * 1e3
        none, anything = (float("nan"),) * len(space.names), (float("inf"),) * len(space.names)
        return Reading(self._count, none, anything, False, found, flags, latency, reason, space=space)

    def _look(self, pixels: FloatArray) -> FloatArray:
        """(m, 3) directions in which the real camera looks at its pixels, in the dome's frame."""
        return self.registration.camera.back_project(pixels)

    def _carry(self, rays: FloatArray, pose: FloatArray | None = None) -> FloatArray:
        """Dots on rays of the real camera as the nominal camera would show them, for a wall of about this pose."""
        camera = self.registration.camera
        reach = (self.unit.layout.positions[:, 2] - camera.origin[2]) / rays[:, 2]
        if pose is not None:
            normal, limit = _wall(self.unit.skin, pose)
            reach = np.minimum(reach, (limit - camera.origin @ normal) / np.maximum(rays @ normal, 1e-3))
        return self._nominal.project(camera.origin + rays * reach[:, None])


@dataclass(frozen=True, eq=False)
class Rest:
    """What images of the untouched dome give: how its dots are found, which marker each is, where the camera is."""

    detector: Detector
    naming: Naming
    registration: Registration


def read_rest(
    images: Iterable[NDArray[Any]],
    unit: Unit,
    detect: DetectSpec | None = None,
    known: KnownPress | None = None,
    refine_lens: bool = False,
) -> Rest:
    """Find and name the dots of the untouched dome, and register the camera.

    Parameters
    ----------
    images
        One or more images at rest, of one size; places are averaged over them.
    unit
        The sensor.
    detect
        How to find dots.
    known
        A press that tells the numbers where the mark does not.
    refine_lens
        Whether focal length and centre are fitted as well (`palpate.sensor.register`).

    Raises
    ------
    PalpateError
        If the dots are not those of the design, or their names are ambiguous.
    """
    images = list(images)
    if not images:
        raise PalpateError("There is no image at rest.", "Record the untouched dome first.")
    detector = prepare_detector(images[0], detect)
    mark = place_orientation_mark(unit.skin, unit.layout) if unit.marked else None
    pattern = build_pattern(unit.layout.positions, build_camera(unit.lens or unit.nominal).project, mark)
    naming = name_markers(detector.find(images[0]).positions_px, pattern)
    if naming.ambiguous and known is not None:
        naming = ask_press(naming, detector.find(known.image).positions_px, known.positions, unit).naming
        if naming.ambiguous:
            raise PalpateError(
                f"The known press leaves {1 + len(naming.alternatives)} ways to number the markers.",
                "Press by a wall slanted by 5° or more, towards 15° from a row of markers.",
            )
    elif unit.marked and naming.ambiguous:
        raise PalpateError(
            f"The orientation mark was not seen; {1 + len(naming.alternatives)} ways to number the markers fit.",
            "Check that it is printed and lit, give an image of a known press, or say that the unit has no mark.",
        )
    naming = _average(naming, detector, images)
    where = register_dome(naming, unit.layout, unit.skin, unit.lens or unit.nominal, refine_lens)
    return Rest(detector, naming, where)


def open_sensor(
    rest: Iterable[NDArray[Any]],
    unit: Unit,
    predictor: Predictor,
    spec: RigSpec | None = None,
    detect: DetectSpec | None = None,
    known: KnownPress | None = None,
) -> Sensor:
    """Begin with images of the untouched dome.

    Parameters
    ----------
    rest
        One or more images at rest, of one size.
    unit, predictor
        The sensor and its model.
    spec, detect
        When to flag, and how to find dots.
    known
        A press that tells the numbers where the mark does not.

    Raises
    ------
    PalpateError
        If the model is that of another design, or where `read_rest` fails.
    """
    check_model(predictor, unit.layout)
    spec = spec or RigSpec()
    seen = read_rest(rest, unit, detect, known, spec.refine_lens)
    return Sensor(unit, predictor, spec, seen.detector, seen.naming, seen.registration)


def check_model(predictor: Predictor, layout: MarkerLayout, space: PoseSpace | None = None) -> None:
    """Refuse a model of another number of markers than the design has, or of another pose, with a `PalpateError`."""
    if predictor.markers != len(layout):
        raise PalpateError(
            f"The model reads {predictor.markers} markers, the design has {len(layout)}.",
            "Use the model of this design.",
        )
    if space is not None and predictor.space != space:
        raise PalpateError(
            f"The model estimates {', '.join(predictor.space.names)}, not {', '.join(space.names)}.",
            "Use a model that was trained on presses of the same obstacle.",
        )


def run_sensor(sensor: Sensor, images: Iterable[NDArray[Any] | PalpateError]) -> Iterator[Reading]:
    """Readings of images one by one; what cannot be read gives a flagged reading and the next is tried."""
    return (sensor.read(image) for image in images)


def _average(naming: Naming, detector: Detector, images: list[NDArray[Any]]) -> Naming:
    """The same naming with positions averaged over all rest images."""
    if len(images) == 1:
        return naming
    tracker = Tracker(Motion(naming.positions_px))
    seen = [tracker.step(detector.find(image).positions_px) for image in images]
    positions = np.mean([sighting.positions_px for sighting in seen], axis=0)
    found = np.mean([sighting.found for sighting in seen], axis=0) > 0.5
    return replace(naming, positions_px=positions, found=found)


def _wall(skin: Skin, pose: FloatArray) -> tuple[FloatArray, float]:
    """Normal n of the wall and the greatest n·x of the inner surface beneath it, its thickness kept, mm."""
    normal = wall_normal(*np.radians(pose[:2]))
    limit = skin.touch(normal) @ normal - skin.thickness - max(float(pose[2]), 0.0) * normal[2]
    return normal, float(limit)
