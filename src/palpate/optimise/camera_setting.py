"""Camera distances and marker diameters of a layout, measured once for every number of rings.

Settings are ranked by evenly spaced rings (about a millisecond each); rings are exchanged in the best settings only.
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
"""Numbers of camera distances and marker diameters tried, and of poses for the rings. By hand."""
_GRAIN_MM = 0.05
"""Step of a marker diameter, mm. By hand."""


@dataclass(frozen=True, eq=False)
class CameraSetting:
    """Camera distance and marker diameter.

    Attributes
    ----------
    camera
        The camera at this distance.
    places
        All printable rings and their information.
    """

    camera: Camera
    places: RingCandidates


def measure_settings(
    twin: Twin, spec: RequirementsSpec, choice: CameraChoice, predicted: AccuracySpec
) -> Iterator[CameraSetting]:
    """Measure all printable rings at every camera distance and marker diameter.

    Raises
    ------
    PalpateError
        If no ring of the smallest markers fits.
    """
    smallest, *larger = dot_diameters(spec)
    limits = PrintLimits(
        max_markers=spec.markers,
        marker_diameter=smallest,
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
    """Marker diameters that are tried, mm, ascending."""
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
    """Settings in which this many markers can be printed and assigned, best first, by evenly spaced rings."""
    found = []
    for number, setting in enumerate(settings):
        try:
            found.append((space_rings_evenly(setting.places, markers).rmse_deg, number))
        except PalpateError:
            continue
    return [settings[number] for _, number in sorted(found)]
