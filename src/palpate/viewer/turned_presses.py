"""A pressed skin with two mirrors, such as a pad, for any tilt and azimuth of the wall.

Fields are interpolated as markers are (`palpate.twin.turned_series`), on the whole skin and in its own frame: no turn
carries one azimuth to another.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, final

import numpy as np

from palpate.core import FloatArray, IntArray
from palpate.fea import Press
from palpate.mesh import Mesh, mesh_skin
from palpate.twin import MIRRORS, TwoMirrorSeries, TwoMirrorTable
from palpate.viewer.pressed_skin import Array32, PressedSkin, SurfaceMotion, find_nodes, nodal_stress_on


@final
@dataclass(frozen=True, eq=False)
class TwoMirrorPresses(PressedSkin):
    """Presses of a skin with two mirrors at several azimuths.

    Attributes
    ----------
    table
        The presses by tilt and azimuth.
    """

    table: TwoMirrorTable

    turned: ClassVar[bool] = False

    @cached_property
    def images(self) -> IntArray:
        """(4, n) numbers of the nodes at the mirror images of every node."""
        return np.stack([find_nodes(self.nodes, mirror * self.nodes) for mirror in MIRRORS])

    @cached_property
    def half(self) -> tuple[Mesh, IntArray]:
        """The half mesh, and for every node (n,) the number of the one on it at x or −x."""
        half = mesh_skin(self.mesh.skin, self.mesh.spec.model_copy(update={"whole": False}))
        folded = np.column_stack([np.abs(self.nodes[:, 0]), self.nodes[:, 1:]])
        return half, find_nodes(half.nodes[: len(half.inner_disc)], folded)

    @cached_property
    def moved(self) -> TwoMirrorSeries:
        """Displacement (n, 3) mm of the nodes."""
        return self.table.series(self._follow(lambda press, mesh: press.interpolated_to(mesh).displacement))

    @cached_property
    def force(self) -> TwoMirrorSeries:
        """Norm () of the wall's force, N."""
        return self.table.series(lambda press: np.repeat(np.linalg.norm(press.force, axis=1)[:, None], 4, axis=1))

    @cached_property
    def stress_mpa(self) -> TwoMirrorSeries:
        """Von Mises stress (n, 1) in MPa; takes some seconds to find."""
        return self.table.series(self._follow(nodal_stress_on))

    def fields(self, tilt_deg: float, azimuth_deg: float, deep: int) -> tuple[Array32, FloatArray]:
        pose = tilt_deg, azimuth_deg, deep
        return self._read(self.moved, *pose), self._read(self.force, *pose).astype(float)

    def stress(self, motion: SurfaceMotion) -> Array32:
        found = self._read(self.stress_mpa, motion.tilt_deg, motion.azimuth_deg, len(motion.depths_mm))
        return found[..., 0].clip(min=0.0)

    def _read(self, series: TwoMirrorSeries, tilt_deg: float, azimuth_deg: float, deep: int) -> Array32:
        """A quantity (k, …) at the first depths of a pose."""
        tilt, azimuth = np.array([tilt_deg]), np.radians([azimuth_deg])
        found = [series.at(tilt, azimuth, float(depth))[0] for depth in self.depths_mm[:deep]]
        return np.stack(found).astype(np.float32)

    def _follow(self, read: Callable[[Press, Mesh], FloatArray]) -> Callable[[Press], FloatArray]:
        """From a nodal field of a press on a mesh to that (i, 4, n, c) of the whole skin and its mirror images."""

        def follow(press: Press) -> FloatArray:
            values = read(press, self.mesh) if press.mesh.spec.whole else self._unfold(read(press, self.half[0]))
            seen = values[:, self.images]
            return seen * MIRRORS[:, None] if values.shape[-1] == 3 else seen

        return follow

    def _unfold(self, values: FloatArray) -> FloatArray:
        """A field (i, h, c) of the half mesh on the whole one (i, n, c)."""
        whole = values[:, self.half[1]]
        if values.shape[-1] == 3:
            whole[:, self.nodes[:, 0] < 0] *= MIRRORS[1]
        return whole


def build_two_mirror_skin(presses: Sequence[Press], mesh: Mesh) -> TwoMirrorPresses:
    """Presses of a skin with two mirrors, to be drawn on a whole mesh; see `palpate.viewer.gather_presses`."""
    table = TwoMirrorTable.of(presses)
    depths = np.concatenate([[0.0], table.depths_mm])
    return TwoMirrorPresses(mesh, presses[0].obstacle, tuple(presses), depths, table.label(depths), table)
