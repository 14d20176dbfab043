"""Inspection of a built skin: print error of each marker, from rest images.

Each blob centre, corrected for the bias of its ellipse, is projected along its ray onto the inner surface of the
nominal skin and compared with its marker. The camera pose is fitted to the same blobs: it absorbs a shift, a rotation
or a tilt of the whole print, and most of a change of scale. The errors are therefore relative to each other.
If the whole print is distorted, its ring model is fitted with the pose (`palpate.vision.print_distortion`).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.camera import Camera, flat_marker_outlines, project_markers
from palpate.core import FloatArray
from palpate.design import Skin
from palpate.sensor.sensor import analyse_rest
from palpate.sensor.spec import InspectionSpec
from palpate.sensor.unit import Unit
from palpate.vision import DetectSpec, PrintDistortion, Registration


@dataclass(frozen=True, eq=False)
class Inspection:
    """Marker positions of a built skin.

    Attributes
    ----------
    unit, registration
        The inspected unit, and its fitted camera pose.
    error
        (m, 2) print error of each marker on the inner surface, mm: along the meridian away from the apex, and along
        the ring, counter-clockwise seen from outside; at the apex along x and y. NaN without a blob.
    mm_per_px
        (m,) maximum motion on the surface per pixel, the effect of an image error.
    tolerance
        Maximum print error, mm.
    """

    unit: Unit
    registration: Registration
    error: FloatArray
    mm_per_px: FloatArray
    tolerance: float

    @property
    def distortion(self) -> PrintDistortion | None:
        """Distortion of the whole print; `None` if only single markers deviate."""
        return self.registration.distortion

    @property
    def distance(self) -> FloatArray:
        """Magnitude (m,) of each print error, mm; NaN without a blob."""
        return np.asarray(np.linalg.norm(self.error, axis=1))

    @property
    def missing(self) -> NDArray[np.intp]:
        """Indices of the markers without a blob."""
        return np.flatnonzero(np.isnan(self.distance))

    @property
    def outside(self) -> NDArray[np.intp]:
        """Indices of the markers whose print error exceeds the tolerance."""
        return np.flatnonzero(self.distance > self.tolerance)

    @property
    def passed(self) -> bool:
        """Whether every marker was found and is within the tolerance."""
        return not len(self.missing) and not len(self.outside)


def inspect_unit(
    images: Iterable[NDArray[Any]], unit: Unit, spec: InspectionSpec | None = None, detect: DetectSpec | None = None
) -> Inspection:
    """Measure the print error of every marker, from one or more rest images of one size.

    `unit` is the design, with the lens of its camera.

    Raises
    ------
    PalpateError
        If the blobs do not match the design, or their assignment is ambiguous.
    """
    registration = analyse_rest(images, unit, detect).registration
    camera, points = registration.camera, unit.design.layout.positions
    outward = unit.design.skin.normal(points)
    nominal = camera.project(points)
    bias = (
        project_markers(camera, flat_marker_outlines(points, outward, unit.design.layout.diameter)).centres - nominal
    )
    seen = nominal + registration.reprojection_residual_px
    found = np.isfinite(seen).all(axis=1)
    dots = np.full_like(points, np.nan)
    dots[found] = _on_dome(camera, unit.design.skin, seen[found])
    axes = np.stack(unit.design.skin.tangents(points)[1:], axis=1)
    error = np.einsum("mij,mj->mi", axes, dots - points)
    return Inspection(
        unit,
        registration,
        error,
        _scale(camera, unit.design.skin, nominal + bias),
        (spec or InspectionSpec()).tolerance,
    )


def _on_dome(camera: Camera, skin: Skin, pixels: FloatArray) -> FloatArray:
    """Return the points (m, 3), mm, at which rays of pixels hit the inner surface; NaN if they miss it."""
    return skin.hit(*camera.sight_lines(pixels))


def _scale(camera: Camera, skin: Skin, pixels: FloatArray) -> FloatArray:
    """Return the maximum motion (m,) on the surface per pixel, mm."""
    half = 0.5
    steps = [
        (_on_dome(camera, skin, pixels + step) - _on_dome(camera, skin, pixels - step)) / (2.0 * half)
        for step in (np.array([half, 0.0]), np.array([0.0, half]))
    ]
    return np.asarray(np.linalg.svd(np.nan_to_num(np.stack(steps, axis=1)), compute_uv=False)[:, 0])
