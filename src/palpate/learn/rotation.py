"""Symmetry of a sensor of revolution: rotated and reflected presses.

Such a sensor is invariant under rotation about its axis and under reflection. If a press moved the markers by a field
u(x), the press rotated or reflected by T moves them by T u(T⁻¹ x), and its tilt is rotated or reflected as well. The
field is interpolated between markers by a thin-plate spline, so any layout will do. Three properties of the recording
are estimated: whether (rx, ry) turn with or against a rotation of the image, the angle between both frames, and which
angles rx and ry are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RBFInterpolator
from scipy.spatial import ConvexHull, Delaunay, cKDTree

from palpate.core import BoolArray, FloatArray

_TURNING, _FIXED, _ODD = ("rx", "ry"), ("depth", "rz", "force"), ("rz",)
"""Axes that rotate with the sensor, invariant ones, and those that a reflection negates."""
_LEAST_TURNED = 8
"""Minimum number of images for a clear sense of rotation. By hand."""
COUNT = 36
"""Number of rotations, evenly spaced. By hand."""
MOST_DOTS = 800
"""Maximum number of markers for this augmentation: the fields' covariance has (2 m)² numbers. By hand."""
_NEAR, _FAR = 12, 0.75
"""Markers of a local interpolation, and distance over spacing from which the nearest is used. By hand."""
_LEAST_INSIDE = 0.25
"""Minimum share of markers inside the filled circle. By hand."""
_MARGIN = 0.3
"""Tolerance of the filled circle, over the spacing: rings are not quite round. By hand."""
_ORDERS = (6, 4, 3, 2)
"""Orders of symmetry that are tried, the highest first. By hand."""
_MOST_ALIKE, _ALIKE = 0.9, 0.3
"""Symmetry of a rotated pattern: minimum share of coinciding markers, tolerance over spacing. By hand."""
_RINGS, _CLEAR, _FRAMES = 3, 0.8, 180
"""Rings of pooled fields, clear residual ratio of the two senses, and angles in half a turn. By hand."""
_MIRROR = np.diag([1.0, -1.0])


ANGLES = ("vector", "ry-rx", "rx-ry")
"""Meanings of rx and ry: a rotation vector, or Euler angles of ``Ry Rx`` or ``Rx Ry``."""


class RotationAugmentation(NamedTuple):
    """Rotation and reflection of poses with images about the centre of the layout.

    Attributes
    ----------
    places_px
        (m, 2) marker positions without a preferred direction, px of the training images.
    base_px
        (m, 2) displacement in the training set that corresponds to these positions; 0 for rest positions.
    sense
        Whether the first two targets, rx and ry, turn with the image (1) or against it (-1).
    frame_rad
        Angle from the image's frame to that of (rx, sense · ry); `None` if reflected presses do not fit.
    angles
        One of `ANGLES`.
    odd
        Indices of further targets that change their sign by a reflection, such as rz.
    """

    places_px: FloatArray
    base_px: FloatArray
    sense: int
    frame_rad: float | None = None
    angles: str = ANGLES[0]
    odd: tuple[int, ...] = ()

    def turns(self, steps: int) -> list[FloatArray]:
        """Rotations (2, 2) of the image by `steps` even steps, from the identity, then the reflections."""
        turned = [rotation(number * (COUNT // steps)) for number in range(steps)]
        return turned if self.frame_rad is None else turned + [turn @ _MIRROR for turn in turned]

    def action(self, turn: FloatArray) -> FloatArray:
        """(2, 2) map of a tilt vector that belongs to the rotation or reflection (2, 2) of the image."""
        angle = self.frame_rad or 0.0
        frame = np.diag([1.0, self.sense]) @ [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
        return np.asarray(frame @ turn @ np.linalg.inv(frame))

    def turn_targets(self, targets: FloatArray, turn: FloatArray) -> FloatArray:
        """Poses (n, k) in degrees and mm that belong to the images after `turn` (2, 2)."""
        found = targets.copy()
        found[:, :2] = tilt_angles(tilt_vector(targets[:, :2], self.angles) @ self.action(turn).T, self.angles)
        if np.linalg.det(turn) < 0:
            found[:, self.odd] *= -1.0
        return found


def tilt_vector(rx_ry: FloatArray, angles: str) -> FloatArray:
    """Rotation vector (n, 2) across the axis, degrees, of angles (n, 2) rx and ry of one of `ANGLES`."""
    if angles == ANGLES[0]:
        return rx_ry
    (sx, sy), (cx, cy) = np.sin(np.radians(rx_ry.T)), np.cos(np.radians(rx_ry.T))
    across = np.stack([sx, sy * cx] if angles == ANGLES[1] else [sx * cy, sy], axis=1)
    size = np.linalg.norm(across, axis=1, keepdims=True)
    return np.asarray(across / np.maximum(size, 1e-12) * np.degrees(np.arctan2(size, (cx * cy)[:, None])))


def tilt_angles(vector: FloatArray, angles: str) -> FloatArray:
    """Inverse of `tilt_vector`."""
    if angles == ANGLES[0]:
        return vector
    size = np.linalg.norm(vector, axis=1)
    x, y = (vector / np.maximum(size, 1e-12)[:, None] * np.sin(np.radians(size))[:, None]).T
    up = np.cos(np.radians(size))
    if angles == ANGLES[1]:
        return np.degrees(np.stack([np.arcsin(x), np.arctan2(y, up)], axis=1))
    return np.degrees(np.stack([np.arctan2(x, up), np.arcsin(y)], axis=1))


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
    def inside(self) -> BoolArray:
        """(m,) markers inside the largest circle about the centre that the layout fills."""
        hull = ConvexHull(self.rest_px).equations
        reach = float((-hull[:, :2] @ self.middle - hull[:, 2]).min())
        spacing = np.median(cKDTree(self.rest_px).query(self.rest_px, 2)[0][:, 1])
        return np.asarray(np.linalg.norm(self.rest_px - self.middle, axis=1) < reach + _MARGIN * spacing)

    @cached_property
    def _spline(self) -> RBFInterpolator:
        count = len(self.rest_px)
        near = min(_NEAR, count)
        return RBFInterpolator(self.rest_px, np.eye(count), neighbors=near, kernel="thin_plate_spline", degree=1)

    def operator(self, turn: FloatArray) -> FloatArray:
        """(2 m, 2 m) rotation or reflection `turn` (2, 2) of fields (2 m,), u and v of a marker adjacent."""
        count = len(self.rest_px)
        if np.array_equal(turn, np.eye(2)):
            return np.eye(2 * count)
        asked = (self.rest_px - self.middle) @ turn + self.middle
        tree = cKDTree(self.rest_px)
        spacing = np.median(tree.query(self.rest_px, 2)[0][:, 1])
        far, nearest = tree.query(asked)
        between = self._spline(asked)
        beyond = (far > _FAR * spacing) & (Delaunay(self.rest_px).find_simplex(asked) < 0)
        between[beyond] = np.eye(count)[nearest[beyond]]
        return np.einsum("gm,ij->gimj", between, turn).reshape(2 * count, 2 * count)

    def operators(self, turns: Sequence[FloatArray]) -> FloatArray:
        """(g, 2 m, 2 m) of several rotations and reflections; those of the last layout are kept."""
        return _operators(self.rest_px.tobytes(), tuple(map(tuple, np.reshape(turns, (-1, 4)).tolist())))

    def spread(self, fields: FloatArray, turns: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Mean (2 m,) and covariance (2 m, 2 m) of fields (n, 2 m) under rotations and reflections."""
        mean, operators = fields.mean(axis=0), self.operators(turns)
        root = (fields - mean) / np.sqrt(len(fields) - 1)
        if len(root) > root.shape[1]:
            root = np.linalg.qr(root, mode="r")
        means = np.array([each @ mean for each in operators])
        within = np.zeros((root.shape[1],) * 2)
        for each in operators:
            moved = root @ each.T
            within += moved.T @ moved / len(operators)
        return means.mean(axis=0), within + np.cov(means.T, bias=True)


@lru_cache(maxsize=2)
def _operators(places: bytes, turns: tuple[tuple[float, ...], ...]) -> FloatArray:
    rotations = RotationOperators(np.frombuffer(places).reshape(-1, 2))
    return np.array([rotations.operator(np.reshape(turn, (2, 2))) for turn in turns])


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


def find_frame(rest_px: FloatArray, moved_px: FloatArray, tilt: FloatArray) -> tuple[int, float]:
    """Sense in which (rx, ry) turn with the image (1, −1; 0 if unclear), and their frame's angle, rad.

    Of the complex displacement u at the place z the means of u and of u* z²/|z|² over rings turn with the image, and
    are all that does so linearly; tilt or its conjugate is regressed on them. If the sensor is invariant under
    reflections as well, the coefficients are real in the frame of the tilt, so that angle is taken.

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
    targets = {sense: tilt[:, 0] + 1j * sense * tilt[:, 1] for sense in (1, -1)}
    left = {sense: _residual(features, target) for sense, target in targets.items()}
    if min(left.values()) > _CLEAR * max(left.values()):
        return 0, 0.0
    sense = min(left, key=lambda one: left[one])
    real, phases = np.vstack([features.real, features.imag]), np.pi * np.arange(_FRAMES) / _FRAMES
    turned = [targets[sense] * np.exp(-1j * phase) for phase in phases]
    errors = [_residual(real, np.concatenate([one.real, one.imag])) for one in turned]
    return sense, float(phases[int(np.argmin(errors))])


def _residual(features: NDArray[Any], target: NDArray[Any]) -> float:
    """Residual sum of squares of a regression on features (n, p)."""
    return float(np.sum(abs(target - features @ np.linalg.lstsq(features, target, rcond=None)[0]) ** 2))


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
    if RotationOperators(rest_px + base).inside.mean() < _LEAST_INSIDE:
        return None
    sense, frame_rad = find_frame(rest_px + base, moved_px - base, targets[:, :2])
    odd = tuple(k for k, axis in enumerate(axes) if axis in _ODD)
    return RotationAugmentation(rest_px + base, base, sense, frame_rad, odd=odd) if sense else None
