"""Inspect a built dome: where each dot was printed, from images of it at rest.

Each dot, its ellipse's bias taken off, is carried along its ray to the inner surface of the nominal dome and compared
with its marker there. The camera's pose is fitted to the same dots: a shift, a turn or a tilt of the whole print is
taken for the camera's, and most of a growth for its distance. What is left is how the dots lie to each other. Where
the whole print is bent, the law of its rings is fitted with the pose (`palpate.vision.print_distortion`).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.camera import Camera, flat_marker_outlines, project_markers
from palpate.core import FloatArray, Spec, parameter
from palpate.design import PRINT_TOLERANCE, Skin
from palpate.sensor.sensor import analyse_rest
from palpate.sensor.unit import Unit
from palpate.vision import DetectSpec, PrintDistortion, Registration


class InspectionSpec(Spec):
    """Tolerance of the print of a unit."""

    tolerance: float = parameter(PRINT_TOLERANCE, unit="mm", meaning="maximum print error of a marker", gt=0, le=5)


@dataclass(frozen=True, eq=False)
class Inspection:
    """Where the dots of a built dome are.

    Attributes
    ----------
    unit, registration
        What was inspected, and the camera's pose that fits best.
    error
        (m, 2) distance of each dot from its marker on the inner surface, mm: along the meridian away from the apex,
        and along the ring counter-clockwise seen from outside; at the apex along x and y. NaN without a dot.
    mm_per_px
        (m,) how far on the surface a dot moves with a pixel, at most: what an error of the image costs.
    tolerance
        Greatest distance allowed, mm.
    """

    unit: Unit
    registration: Registration
    error: FloatArray
    mm_per_px: FloatArray
    tolerance: float

    @property
    def distortion(self) -> PrintDistortion | None:
        """How the print is bent as a whole; `None` where the dots lie as designed, but for each one's own error."""
        return self.registration.distortion

    @property
    def distance(self) -> FloatArray:
        """(m,) distance of each dot from its marker, mm; NaN without a dot."""
        return np.asarray(np.linalg.norm(self.error, axis=1))

    @property
    def missing(self) -> NDArray[np.intp]:
        """Numbers of the markers without a dot."""
        return np.flatnonzero(np.isnan(self.distance))

    @property
    def outside(self) -> NDArray[np.intp]:
        """Numbers of the markers farther from their place than the tolerance."""
        return np.flatnonzero(self.distance > self.tolerance)

    @property
    def passed(self) -> bool:
        """Whether every dot is there and in its place."""
        return not len(self.missing) and not len(self.outside)


def inspect_unit(
    images: Iterable[NDArray[Any]], unit: Unit, spec: InspectionSpec | None = None, detect: DetectSpec | None = None
) -> Inspection:
    """Find the print error of every marker.

    Parameters
    ----------
    images
        One or more images at rest, of one size.
    unit
        The design, and the lens of its camera.
    spec, detect
        What must be kept, and how to find dots.

    Raises
    ------
    PalpateError
        If the dots are not those of the design, or their names are ambiguous.
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
    """(m, 3) where the rays of pixels meet the inner surface from inside, mm; NaN where they miss it."""
    return skin.hit(*camera.sight_lines(pixels))


def _scale(camera: Camera, skin: Skin, pixels: FloatArray) -> FloatArray:
    """(m,) greatest motion on the surface that a pixel stands for, mm."""
    half = 0.5
    steps = [
        (_on_dome(camera, skin, pixels + step) - _on_dome(camera, skin, pixels - step)) / (2.0 * half)
        for step in (np.array([half, 0.0]), np.array([0.0, half]))
    ]
    return np.asarray(np.linalg.svd(np.nan_to_num(np.stack(steps, axis=1)), compute_uv=False)[:, 0])
