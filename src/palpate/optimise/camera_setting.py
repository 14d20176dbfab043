"""The setting of a layout: a camera's distance and a diameter of dots, measured once for every number of rings.

Which of them suits a number of rings is decided by rings that are even, a millisecond each; rings are exchanged only
in the settings that are best by these.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from palpate.calibration import AccuracySpec
from palpate.camera import Camera, build_camera
from palpate.core import PalpateError
from palpate.optimise.choose_rings import (
    PrintLimits,
    RingCandidates,
    measure_ring_candidates,
    resize_dots,
    space_rings_evenly,
)
from palpate.optimise.spec import CameraChoice, RequirementsSpec
from palpate.surrogate import Twin

_DISTANCES, _DIAMETERS, _POSES = 4, 4, 24
"""Distances of a camera and diameters of dots that are tried, and poses by which rings are chosen."""
_GRAIN_MM = 0.05
"""Steps of a diameter that a drawing has."""


@dataclass(frozen=True, eq=False)
class CameraSetting:
    """A distance of a camera with dots of one diameter.

    Attributes
    ----------
    camera
        The camera where it is.
    places
        Every ring that might be printed, and what it tells.
    """

    camera: Camera
    places: RingCandidates


def measure_settings(
    twin: Twin, spec: RequirementsSpec, choice: CameraChoice, predicted: AccuracySpec
) -> Iterator[CameraSetting]:
    """Measure all rings that might be printed, at every distance of a camera, with dots of every diameter.

    Raises
    ------
    PalpateError
        If there is no room for a ring of the smallest dots.
    """
    smallest, *larger = dot_diameters(spec)
    limits = PrintLimits(
        max_markers=spec.markers,
        dot=smallest,
        gap=spec.process.min_gap,
        max_slope_deg=spec.process.max_slope_deg,
        on_arc=spec.process.mapping == "arc",
    )
    least, most = choice.distances
    for distance in np.linspace(least, most, _DISTANCES if most > least else 1):
        camera = build_camera(choice.camera.model_copy(update={"distance": round(float(distance), 2)}))
        places = measure_ring_candidates(twin, camera, spec.tolerance, replace(predicted, poses=_POSES), limits)
        yield CameraSetting(camera, places)
        for dot in larger:
            yield CameraSetting(camera, resize_dots(places, twin.skin, camera, dot, predicted.noise_px))


def dot_diameters(spec: RequirementsSpec) -> tuple[float, ...]:
    """Diameters of dots that are tried, mm, the smallest first."""
    greatest = spec.max_marker_diameter or spec.min_marker_diameter
    between = np.geomspace(spec.min_marker_diameter, greatest, _DIAMETERS)[1:-1]
    rounded = (round(round(float(step) / _GRAIN_MM) * _GRAIN_MM, 2) for step in between)
    return tuple(
        dict.fromkeys(
            (
                spec.min_marker_diameter,
                *(step for step in rounded if spec.min_marker_diameter < step < greatest),
                greatest,
            )
        )
    )


def rank_settings(settings: Sequence[CameraSetting], markers: int) -> list[CameraSetting]:
    """Settings in which so many markers can be printed and told apart, best first, by rings that are even."""
    found = []
    for number, setting in enumerate(settings):
        try:
            found.append((space_rings_evenly(setting.places, markers).rmse_deg, number))
        except PalpateError:
            continue
    return [settings[number] for _, number in sorted(found)]
