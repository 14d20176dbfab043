"""The force on the wall for any tilt, interpolated from a handful of presses as their markers are (`field`).

A wall tilted by −t bears what the wall tilted by t bears, turned by half a turn: up the slope and along the axis of
the tilt the opposite, along the dome's axis the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.fea import Press
from palpate.twin.tilt_runs import TiltRuns, cut_into_runs, label_presses, match_depths, shared_depths

_PARITY = np.array([-1.0, 1.0, -1.0])


@dataclass(frozen=True)
class ForceField:
    """Force on the wall over the disc of tilts, one image a depth.

    Attributes
    ----------
    runs
        Runs of tilts at each depth, whose splines give the force up the slope, along the dome's axis, and along the
        axis of the tilt, N.
    """

    runs: TiltRuns

    def forces(self, rx_deg: FloatArray, ry_deg: FloatArray, depth_index: int) -> FloatArray:
        """Force (n, 3) N of the dome on the wall, dome's frame, at rx and ry (n,) in degrees and a depth by number.

        NaN for a pose that no run covers.
        """
        tilt, azimuth = np.hypot(rx_deg, ry_deg), np.arctan2(ry_deg, rx_deg)
        parts = np.full((len(tilt), 3), np.nan)
        for chosen, values in self.runs.read(tilt, depth_index):
            parts[chosen] = values
        slope, axial, axis = parts.T
        c, s = np.cos(azimuth), np.sin(azimuth)
        return np.column_stack([axis * c - slope * s, slope * c + axis * s, axial])


def build_force_field(presses: Sequence[Press]) -> ForceField:
    """Interpolate the forces of presses of one skin under walls of several tilts.

    Raises
    ------
    PalpateError
        If there is no press, a tilt appears twice, image steps differ, or what presses is no wall.
    """
    if not all(press.obstacle.pose_space.is_tilt for press in presses):
        raise PalpateError(
            "Forces are interpolated under walls.", "Read those of single presses instead.", code="forces-need-wall"
        )
    for press in presses:
        press.mesh.skin.require_revolution(
            "its forces are not interpolated",
            "Read those of single presses; leave `forces` out.",
            code="forces-need-revolution",
        )
    depths = shared_depths(presses)
    presses = sorted(presses, key=lambda press: press.obstacle.radial)
    parts = np.full((len(depths), len(presses), 3), np.nan)
    for column, press in enumerate(presses):
        depth, image = match_depths(depths, press)
        parts[depth, column] = forces_along_tilt(press, press.force)[image]
    tilts = np.array([press.obstacle.radial for press in presses], dtype=float)
    ended = [str(press.ended) for press in presses]
    return ForceField(cut_into_runs(tilts, label_presses(presses, depths), ended, parts, _PARITY * parts))


def forces_along_tilt(press: Press, force: FloatArray) -> FloatArray:
    """Force (n, 3) N up the slope, along the dome's axis and the tilt's, of forces (n, 3) in the dome's frame."""
    azimuth = np.radians(press.obstacle.turn_deg)
    c, s = np.cos(azimuth), np.sin(azimuth)
    return np.stack([force[:, 1] * c - force[:, 0] * s, force[:, 2], force[:, 0] * c + force[:, 1] * s], axis=-1)
