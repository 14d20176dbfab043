"""A pressed skin of revolution for any tilt of the wall, interpolated between the presses that were solved.

The displacement u of the nodes lies in the frame whose y-z plane is the tilt plane, so one press serves every
azimuth. A wall tilted by −t is the wall tilted by t seen in the mirror y → −y, which continues u to negative tilts:

    u(x, y, z; −t) = M u(x, −y, z; t),      M = diag(1, −1, 1)

A spline through a run of tilts (see `palpate.twin.tilt_runs`) is a weighted sum of its presses and of their mirror
images; here the weights are what is interpolated.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, final

import numpy as np

from palpate.core import FloatArray, IntArray, TextArray
from palpate.fea import Press, WallSpec
from palpate.mesh import Mesh
from palpate.twin import TiltRuns, cut_into_runs, label_presses, match_depths, shared_depths
from palpate.viewer.pressed_skin import SAME_MM, Array32, PressedSkin, SurfaceMotion, find_nodes, nodal_stress_on


@final
@dataclass(frozen=True, eq=False)
class RevolvedPresses(PressedSkin):
    """Presses of half a skin of revolution; splines of `runs` give weights (2, t) of them and their mirror images."""

    turned: ClassVar[bool] = True

    @cached_property
    def mirrored(self) -> IntArray:
        """(n,) for each node the one across y = 0."""
        return find_nodes(self.nodes, self.nodes * [1.0, -1.0, 1.0])

    @cached_property
    def displacement(self) -> Array32:
        """(d, t, n, 3) mm of the nodes; zero where a press ended before."""
        moved = [press.interpolated_to(self.mesh).displacement for press in self.presses]
        return self._gather(moved, *self.nodes.shape).astype(np.float32)

    @cached_property
    def force_n(self) -> FloatArray:
        """(d, t) norm of the wall's force; zero where a press ended before."""
        return self._gather([np.linalg.norm(press.force, axis=1) for press in self.presses])

    @cached_property
    def stress_mpa(self) -> Array32:
        """(d, t, n, 1) von Mises Cauchy stress in MPa of the presses, zero at rest; takes about a second to find."""
        stress = [nodal_stress_on(press, self.mesh) for press in self.presses]
        return self._gather(stress, len(self.nodes), 1).astype(np.float32)

    def fields(self, tilt_deg: float, azimuth_deg: float, deep: int) -> tuple[Array32, FloatArray]:
        weights = self._weights(tilt_deg, deep)
        return self.blend(self.displacement, weights), (weights.sum(axis=1) * self.force_n[:deep]).sum(axis=1)

    def stress(self, motion: SurfaceMotion) -> Array32:
        weights = self._weights(motion.tilt_deg, len(motion.depths_mm))
        return self.blend(self.stress_mpa, weights)[..., 0].clip(min=0.0)

    def _weights(self, tilt_deg: float, deep: int) -> Array32:
        """Weights (k, 2, t) of the solved presses and of their mirror images at the first depths."""
        tilt = np.array([tilt_deg])
        return np.concatenate([next(self.runs.read(tilt, k))[1] for k in range(deep)]).astype(np.float32)

    def blend(self, field: Array32, weights: Array32) -> Array32:
        """Weighted sum of a nodal field of every press and of its mirror image.

        Parameters
        ----------
        field
            (d, t, n, c): a vector of the tilt frame for c = 3, scalars for c = 1.
        weights
            (k, 2, t), of the first k depths.

        Returns
        -------
        ndarray
            (k, n, c)
        """
        count, nodes, parts = len(weights), field.shape[2], field.shape[3]
        flat = field[:count].reshape(count, field.shape[1], nodes * parts)
        plain = np.matmul(weights[:, 0, None], flat).reshape(count, nodes, parts)
        if not weights[:, 1].any():
            return plain
        other = np.matmul(weights[:, 1, None], flat).reshape(count, nodes, parts)[:, self.mirrored]
        if parts == 3:
            other = other * np.array([1, -1, 1], np.float32)
        total: Array32 = plain + other
        return total

    def _gather(self, fields: Sequence[FloatArray], *shape: int) -> FloatArray:
        """A field (images, …) of each press at the common depths: (d, t, …), zero where a press ended before."""
        gathered = np.zeros((len(self.depths_mm), len(self.tilts_deg), *shape))
        for column, (press, values) in enumerate(zip(self.presses, fields, strict=False)):
            depth, image = match_depths(self.depths_mm, press)
            gathered[depth, column] = values[image]
        return gathered


def gather_revolved(presses: Sequence[Press], mesh: Mesh) -> RevolvedPresses:
    """Presses of half a skin of revolution, to be drawn on a mesh; see `palpate.viewer.gather_presses`."""
    presses = tuple(sorted(presses, key=lambda press: press.obstacle.radial))
    depths = _depths(presses)
    tilts = np.array([press.obstacle.radial for press in presses], float)
    runs = _weigh(tilts, label_presses(presses, depths), [str(press.ended) for press in presses])
    return RevolvedPresses(mesh, presses[0].obstacle, presses, depths, runs)


def rest_skin(mesh: Mesh, tilt_deg: float = 0.0) -> RevolvedPresses:
    """A skin of revolution that was never pressed, as a press of no depth by a wall of a tilt (degrees)."""
    runs = _weigh(np.array([tilt_deg]), np.full((1, 1), "flat", dtype="U16"), ["not pressed yet"])
    return RevolvedPresses(mesh, WallSpec(), (), np.zeros(1), runs)


def _weigh(tilts_deg: FloatArray, branch: TextArray, ended: Sequence[str]) -> TiltRuns:
    """Weights (2, t) of the presses and of their mirror images, for each depth."""
    count = len(tilts_deg)
    own = np.zeros((count, 2, count))
    own[:, 0] = np.eye(count)
    shape = (len(branch), *own.shape)
    return cut_into_runs(tilts_deg, branch, ended, np.broadcast_to(own, shape), np.broadcast_to(own[:, ::-1], shape))


def _depths(presses: Sequence[Press]) -> FloatArray:
    """Depths of rest, of all images and of full depth; of one press alone, of its end as well."""
    images = shared_depths(presses)
    reached = max(float(press.depth.max()) for press in presses) + SAME_MM
    # where a press ended early is an image of it alone; full depth is one of all that came so far
    ends = presses[0].depth if len(presses) == 1 else np.array([press.obstacle.depth for press in presses])
    depths: FloatArray = np.unique(np.round(np.concatenate([[0.0], images, ends[ends <= reached]]), 6))
    return depths
