"""Turned presses: what a sensor of revolution would have seen if it had been pressed from another side.

Seen from below, such a sensor is alike in all directions. Where a press moved the dots by a field u(x), the press
turned by an angle about the axis would have moved them by R u(R⁻¹ x), and its tilt is the one that was recorded,
turned as well. So one recorded press teaches presses from all sides, whatever the pattern of the dots: the field is
read between dots by a thin-plate spline. Whether a turn of the image turns (rx, ry) along or against it, the
recording itself tells.
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
"""Axes that turn with the sensor, and those that stay as they are."""
_LEAST_TURNED = 20
"""Images that find the sense: with fewer, it is not clear."""
COUNT = 36
"""Turns that are drawn from, evenly around."""
MOST_DOTS = 800
"""Dots of the largest layout that is turned: the fields' covariance has (2 m)² numbers."""
_NEAR, _FAR = 12, 0.75
"""Dots by which a field is read between them; outside the layout the nearest dot speaks, from this distance over the
spacing on."""
_ORDERS = (6, 4, 3, 2)
_MOST_ALIKE, _ALIKE = 0.9, 0.3
"""Share of the dots that must come to lie on others when a pattern is turned, and how near, over their spacing."""
_RINGS, _CLEAR = 5, 0.8
"""Rings over which fields are pooled to tell the sense, and residual over the other sense's that makes it clear."""


class RotationAugmentation(NamedTuple):
    """How poses turn with images about the middle of the dots (`palpate.learn.rotation`).

    Attributes
    ----------
    places_px
        (m, 2) dots as they stand when nothing favours a side, px of the images or pictures that teach.
    base_px
        (m, 2) displacement by which a lesson on dots tells of these places; 0 where they are those at rest.
    sense
        Whether the first two targets, rx and ry, turn with the image (1) or against it (-1).
    """

    places_px: FloatArray
    base_px: FloatArray
    sense: int


@dataclass(frozen=True, eq=False)
class RotationOperators:
    """Turns of fields of displacements about the middle of a layout.

    Attributes
    ----------
    rest_px
        (m, 2) dots at rest, px.
    """

    rest_px: FloatArray

    @cached_property
    def middle(self) -> FloatArray:
        """(2,) middle of the layout, px: half way between its farthest dots, which a missing one moves little."""
        return np.asarray((self.rest_px.min(axis=0) + self.rest_px.max(axis=0)) / 2)

    @cached_property
    def _spline(self) -> RBFInterpolator:
        count = len(self.rest_px)
        near = min(_NEAR, count)
        return RBFInterpolator(self.rest_px, np.eye(count), neighbors=near, kernel="thin_plate_spline", degree=1)

    def operator(self, number: int) -> FloatArray:
        """(2 m, 2 m) that turns fields (2 m,), the two numbers of a dot side by side, by `number` steps."""
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
        """Mean (2 m,) and covariance (2 m, 2 m) of fields (n, 2 m) and of all that they give by every third turn."""
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
    """Into how many alike parts a layout (m, 2) is cut by turns: 6 of a hexagon, 4 of a square, 1 of most others."""
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
        (m, 2) dots at rest, (n, m, 2) displacements, (n, 2) rx and ry in degrees.
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
    """How (rx, ry) turn with the images; `None` if they cannot, or if another target might.

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
