"""Where a built dome sits over its camera, from one image at rest.

The six numbers of the camera's pose (offset, distance, two tilts, roll) are those for which the printed layout
projects onto the dots, by least squares with a loss that forgives misprints; the traces' centres are corrected for
the ellipse of a tilted disc. What is left over at each marker is its print error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial import cKDTree

from palpate.camera import Camera, CameraSpec, build_camera, centre_bias, dot_edges
from palpate.core import PalpateError
from palpate.design import Dome, MarkerLayout
from palpate.markers import Naming

Array = NDArray[np.float64]
_POSE = ("offset_x", "offset_y", "distance", "tilt_x_deg", "tilt_y_deg", "roll_deg")
_LEAST_MARKERS = 6
_FORGIVEN_PX = 1.0
"""Distance beyond which a misprint no longer pulls with its square."""


@dataclass(frozen=True, eq=False)
class Registration:
    """The pose of a camera under a dome.

    Attributes
    ----------
    camera
        The camera where it is.
    rms_px
        Root of the mean squared distance of found dots from where they should be.
    print_error_px
        (m, 2) that distance for each marker; NaN where no dot was found.
    sd
        (6,) standard deviation of offset x, y (mm), distance (mm), tilts and roll (degrees).
    """

    camera: Camera
    rms_px: float
    print_error_px: Array
    sd: Array


def register_dome(
    naming: Naming, layout: MarkerLayout, dome: Dome, nominal: CameraSpec | None = None
) -> Registration:
    """Find the pose of the camera from named markers at rest.

    Parameters
    ----------
    naming
        Markers and their dots.
    layout, dome
        What was printed, on what.
    nominal
        The lens, and about where the camera is.

    Raises
    ------
    PalpateError
        If too few markers have a dot, the image is mirrored, or no pose with the dome before the camera fits.
    """
    nominal = nominal or CameraSpec()
    if naming.found.sum() < _LEAST_MARKERS:
        raise PalpateError(
            f"{naming.found.sum()} named markers do not give a pose, {_LEAST_MARKERS} are needed.", "Check the light."
        )
    if naming.mirrored:
        raise PalpateError(
            "The image is mirrored: left is right.", "Flip it before it is read, or turn off the mirror."
        )
    points, seen = layout.positions[naming.found], naming.positions_px[naming.found]
    normals = (points - np.array([0.0, 0.0, dome.center_z])) / dome.radius
    edges = dot_edges(points, normals, layout.diameter)
    start = np.array([getattr(nominal, name) for name in _POSE])
    start[5] = (start[5] - naming.turn_deg + 180.0) % 360.0 - 180.0
    bias = centre_bias(_posed(nominal, start), points, edges)

    def miss(pose: Array) -> Array:
        projected = _posed(nominal, pose).project(points) + bias
        return np.nan_to_num(projected - seen, nan=1e3).reshape(-1)

    low = np.array([-50.0, -50.0, 1.0, -44.0, -44.0, -np.inf])
    high = np.array([50.0, 50.0, 999.0, 44.0, 44.0, np.inf])
    fit = least_squares(
        miss, start, bounds=(low, high), loss="soft_l1", f_scale=_FORGIVEN_PX, x_scale=[1, 1, 1, 1, 1, 5]
    )
    left = miss(fit.x).reshape(-1, 2)
    rms = float(np.sqrt(np.mean((left**2).sum(axis=1))))
    spacing = float(np.median(cKDTree(seen).query(seen, 2)[0][:, 1]))
    if rms > 0.05 * spacing:
        raise PalpateError(
            f"The markers fit the design to {rms:.1f} px only.",
            "Check height, base radius and marker count, and the camera's focal length.",
        )
    errors = np.full((len(layout), 2), np.nan)
    errors[naming.found] = -left
    spread = np.linalg.pinv(fit.jac.T @ fit.jac) * 2.0 * fit.cost / max(left.size - 6, 1)
    return Registration(_posed(nominal, fit.x), rms, errors, np.sqrt(np.diag(spread)))


def _posed(nominal: CameraSpec, pose: Array) -> Camera:
    values = dict(zip(_POSE, (float(value) for value in pose), strict=True))
    values["roll_deg"] = (values["roll_deg"] + 180.0) % 360.0 - 180.0
    return build_camera(nominal.model_copy(update=values))
