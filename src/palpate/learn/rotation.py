"""Augmentation by rotated presses of a sensor of revolution.

Such a sensor is invariant under rotation about its axis. If a press moved the markers by a field u(x), the press
rotated about the axis moves them by R u(R⁻¹ x), and its tilt is rotated as well. One recorded press thus gives
presses from all directions for any layout: the field is interpolated between markers by a thin-plate spline. Whether
(rx, ry) turn with or against a rotation of the image is estimated from the recording.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.spatial import Delaunay, cKDTree

from palpate.core import FloatArray

_TURNING, _FIXED = ("rx", "ry"), ("depth", "rz", "force")
"""Axes that rotate with the sensor, and those that are invariant."""
_LEAST_TURNED = 20
"""Minimum number of images for a clear sense of rotation."""
COUNT = 36
"""Number of rotations, evenly spaced."""
MOST_DOTS = 800
"""Maximum number of markers for this augmentation: the fields' covariance has (2 m)² numbers."""
_NEAR, _FAR = 12, 0.75
"""Markers of a local interpolation, and distance over spacing from which the nearest is used."""
_ORDERS = (6, 4, 3, 2)
_MOST_ALIKE, _ALIKE = 0.9, 0.3
"""Symmetry of a rotated pattern: minimum share of coinciding markers, tolerance over spacing."""
_RINGS, _CLEAR = 5, 0.8
"""Rings over which fields are pooled, and residual ratio of the two senses that is clear."""


class RotationAugmentation(NamedTuple):
    """Rotation of poses with images about the centre of the layout (`palpate.learn.rotation`).

    Attributes
    ----------
    places_px
        (m, 2) marker positions without a preferred direction, px of the training images.
    base_px
        (m, 2) displacement in the training set that corresponds to these positions; 0 for rest positions.
    sense
        Whether the first two targets, rx and ry, turn with the image (1) or against it (-1).
    """

    places_px: FloatArray
    base_px: FloatArray
    sense: int


@dataclass(frozen=True, eq=False)
class RotationOperators:
    """Rotations of displacement fields about the centre of a layout.

    Attributes
    ----------
    rest_px
        (m, 2) markers at rest, px.
    """

    rest_px: FloatArray

    @cached_property
    def middle(self) -> FloatArray:
        """(2,) centre of the layout, px: mid-point of its extreme markers, insensitive to a missing one."""
        return np.asarray((self.rest_px.min(axis=0) + self.rest_px.max(axis=0)) / 2)

    @cached_property
    def _spline(self) -> RBFInterpolator:
        count = len(self.rest_px)
        near = min(_NEAR, count)
        return RBFInterpolator(self.rest_px, np.eye(count), neighbors=near, kernel="thin_plate_spline", degree=1)

    def operator(self, number: int) -> FloatArray:
        """(2 m, 2 m) rotation of fields (2 m,), u and v of a marker adjacent, by `number` steps."""
        count = len(self.rest_px)
        if number % COUNT == 0:
            return np.eye(2 * count)
        turn = rotation(number)
        asked = (self.rest_px - self.middle) @ turn + self.middle
        tree = cKDTree(self.rest_px)
        spacing = np.median(tree.query(self.rest_px, 2)[0][:, 1])
        far, nearest = tree.query(asked)
        between = self._spline(asked)
        beyond = (far > _FAR * spacing) & (Delaunay(self.rest_px).find_simplex(asked) < 0)
        between[beyond] = np.eye(count)[nearest[beyond]]
        return np.einsum("gm,ij->gimj", between, turn).reshape(2 * count, 2 * count)

    def spread(self, fields: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Mean (2 m,) and covariance (2 m, 2 m) of fields (n, 2 m) under every third rotation."""
        mean, own = fields.mean(axis=0), np.cov(fields.T)
        operators = [self.operator(number) for number in range(0, COUNT, 3)]
        means = np.array([each @ mean for each in operators])
        within = np.mean([each @ own @ each.T for each in operators], axis=0)
        return means.mean(axis=0), within + np.cov(means.T, bias=True)


def rotation(number: int) -> FloatArray:
    """(2, 2) of a turn by `number` steps, from column towards row of the image."""
    angle = 2.0 * np.pi * number / COUNT
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def pattern_order(rest_px: FloatArray) -> int:
    """Order of rotational symmetry of a layout (m, 2): 6 of a hexagon, 4 of a square, 1 of most."""
    about = rest_px - RotationOperators(rest_px).middle
    tree = cKDTree(about)
    spacing = float(np.median(tree.query(about, 2)[0][:, 1]))
    for order in _ORDERS:
        off = tree.query(about @ rotation(COUNT // order).T)[0]
        if np.quantile(off, _MOST_ALIKE) < _ALIKE * spacing:
            return order
    return 1


def find_rotation_sense(rest_px: FloatArray, moved_px: FloatArray, tilt: FloatArray) -> int:
    """Whether (rx, ry) turn with the image (1), against it (−1), or whether neither is clear (0).

    Of the complex displacement u at the place z the means of u and of u* z²/|z|² over rings turn with the image, and
    are all that does so linearly; tilt or its conjugate is regressed on them.

    Parameters
    ----------
    rest_px, moved_px, tilt
        (m, 2) markers at rest, (n, m, 2) displacements, (n, 2) rx and ry in degrees.
    """
    apart = rest_px - RotationOperators(rest_px).middle
    place, moved = apart[:, 0] + 1j * apart[:, 1], moved_px[..., 0] + 1j * moved_px[..., 1]
    ring = np.minimum((np.argsort(np.argsort(abs(place))) * _RINGS) // len(place), _RINGS - 1)
    outward = (place / np.maximum(abs(place), 1e-9)) ** 2
    pooled = np.array([moved[:, ring == k].mean(axis=1) for k in range(_RINGS)])
    mirrored = np.array([(moved.conj() * outward)[:, ring == k].mean(axis=1) for k in range(_RINGS)])
    features = np.vstack([pooled, mirrored]).T
    left = []
    for target in (tilt[:, 0] + 1j * tilt[:, 1], tilt[:, 0] - 1j * tilt[:, 1]):
        found = np.linalg.lstsq(features, target, rcond=None)[0]
        left.append(float(np.mean(abs(target - features @ found) ** 2)))
    if min(left) > _CLEAR * max(left):
        return 0
    return 1 if left[0] < left[1] else -1


def find_rotation(
    rest_px: FloatArray, moved_px: FloatArray, targets: FloatArray, axes: Sequence[str], at_rest: bool
) -> RotationAugmentation | None:
    """Find the rotation of (rx, ry) with the images; `None` if they or another target forbid it.

    Parameters
    ----------
    rest_px, moved_px, targets
        (m, 2) layout, (n, m, 2) displacements, (n, k) poses.
    axes
        Axis of each target.
    at_rest
        Whether the layout is that of a rest image. The layout of a press leans; its markers are then counted from
        their mean positions.
    """
    if tuple(axes[:2]) != _TURNING or any(axis not in _FIXED for axis in axes[2:]):
        return None
    if len(rest_px) > MOST_DOTS or len(moved_px) < _LEAST_TURNED:
        return None
    base = np.zeros_like(rest_px) if at_rest else moved_px.mean(axis=0)
    sense = find_rotation_sense(rest_px + base, moved_px - base, targets[:, :2])
    return RotationAugmentation(rest_px + base, base, sense) if sense else None
