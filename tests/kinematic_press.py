"""A made-up press with the symmetries of a real one, in closed form: only for tests.

The displacement is a function of the undeformed point, the dome's axis and the wall's normal alone, so it
turns with the wall's azimuth, is mirror-symmetric about the tilt plane and smooth through the straight press.
"""

from dataclasses import dataclass, field
from types import SimpleNamespace

import numpy as np

from palpate.design import TILT_SPACE, Symmetry

RADIUS = 20.0
STEP = 0.8
E_Z = np.array([0.0, 0.0, 1.0])


def wall_normal(rx_deg, ry_deg):
    """Outward normal (..., 3): cosθ e_z + sinθ (ry, −rx, 0) / θ."""
    theta = np.deg2rad(np.hypot(rx_deg, ry_deg))
    scale = np.sinc(theta / np.pi) * np.deg2rad(1.0)
    return np.stack([scale * ry_deg, -scale * rx_deg, np.cos(theta)], axis=-1)


def kinematic_positions(points, rx_deg, ry_deg, depth, inverted=False):
    """Deformed positions (m, 3) of points (m, 3) on the inner hemisphere."""
    normal = wall_normal(rx_deg, ry_deg)
    nearness = np.exp(-(RADIUS - points @ normal) / 6.0)[:, None]
    outward = points - (points @ normal)[:, None] * normal
    clamp = (points[:, 2:] / RADIUS) ** 2
    moved = clamp * (-depth * nearness * (0.7 * E_Z + 0.3 * normal) + 0.02 * depth * outward * (1 - nearness))
    return points + moved - (3.0 * nearness**4 * normal if inverted else 0.0)


@dataclass
class KinematicPress:
    tilt_deg: float
    azimuth_deg: float = 0.0
    reached: float = 8.0
    inverted_from: float = np.inf
    ended: str = "depth reached"
    depth: np.ndarray = field(init=False)
    branch: np.ndarray = field(init=False)
    derivatives: dict = field(default_factory=dict)

    def __post_init__(self):
        depth = STEP * np.arange(int(self.reached / STEP + 1e-9) + 1)
        if self.reached - depth[-1] > 1e-6:
            depth = np.append(depth, self.reached)
        self.depth = depth
        self.branch = np.where(depth >= self.inverted_from, "inverted", "flat")
        skin = SimpleNamespace(symmetry=Symmetry.REVOLVED, require_revolution=lambda why, remedy: None)
        self.mesh = SimpleNamespace(skin=skin)
        self.ended_depth = self.reached
        self.obstacle = SimpleNamespace(
            radial=self.tilt_deg,
            turn_deg=self.azimuth_deg,
            depth_step=STEP,
            depth=8.0,
            pose_space=TILT_SPACE,
            centred=True,
        )

    def positions(self, points):
        azimuth = np.deg2rad(self.azimuth_deg)
        rx, ry = self.tilt_deg * np.cos(azimuth), self.tilt_deg * np.sin(azimuth)
        return np.stack(
            [
                kinematic_positions(points, rx, ry, depth, branch == "inverted")
                for depth, branch in zip(self.depth, self.branch, strict=True)
            ]
        )

    def displacement_at(self, points, by=""):
        assert not by, "a made-up press has no derivatives"
        return self.positions(points) - points


def rings(diameters=(10, 20, 30)):
    """Layout with one marker at the apex and rings of 6, 12, 18, … on the inner hemisphere."""
    rows = [[0.0, 0.0]]
    for number, diameter in enumerate(diameters, start=1):
        azimuth = 2 * np.pi * np.arange(6 * number) / (6 * number)
        rows += list(np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1) * diameter / 2)
    flat = np.array(rows)
    height = np.sqrt(RADIUS**2 - (flat**2).sum(axis=1))
    return SimpleNamespace(positions=np.column_stack([flat, height]), diameter=1.5)


class PinholeCamera:
    """Looks up the axis from 48 mm below the base plane."""

    width_px, height_px = 346, 260

    def project(self, points):
        return 297.5 * points[..., :2] / (points[..., 2:] + 48.0) + np.array([174.9, 128.2])

    def visible(self, points, dome):
        u, v = np.moveaxis(self.project(points), -1, 0)
        return (u >= 0) & (u < self.width_px) & (v >= 0) & (v < self.height_px)


def solved(tilts=range(0, 13, 2), **changes):
    return [KinematicPress(float(tilt), **changes) for tilt in tilts]
