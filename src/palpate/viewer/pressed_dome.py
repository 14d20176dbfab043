"""A pressed dome for any tilt of the wall, interpolated between the presses that were solved.

The displacement u of the nodes lies in the frame whose y-z plane is the tilt plane, so one press serves every
azimuth. A wall tilted by −t is the wall tilted by t seen in the mirror y → −y, which continues u to negative tilts:

    u(x, y, z; −t) = M u(x, −y, z; t),      M = diag(1, −1, 1)

A spline through a run of tilts (see `palpate.twin.tilt_runs`) is a weighted sum of its presses and of their mirror
images; here the weights are what is interpolated. Markers are those of the dataset: `build_field` at the same depths.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from palpate.core import FloatArray, PalpateError, TextArray
from palpate.design import MarkerLayout, rotation_vector
from palpate.fea import Press, nodal_von_mises
from palpate.mesh import Mesh, mesh_skin
from palpate.twin import MarkerField, TiltRuns, build_field, cut_into_runs, label_presses, match_depths, shared_depths

Array32 = NDArray[np.float32]

SAME_MM, SAME_DEG = 1e-6, 1e-9


@dataclass(frozen=True, eq=False)
class SurfaceMotion:
    """One press at one tilt of the wall, from first touch as deep as it is known.

    Attributes
    ----------
    tilt_deg
        Of the wall.
    depths_mm
        (k,) depths, from 0.
    displacement
        (k, n, 3) mm of the mesh's nodes, in the tilt frame.
    force_n
        (k,) norm of the wall's force.
    branch
        (k,) label of each depth.
    ended
        Why it goes no deeper.
    weights
        (k, 2, t) weights of the solved presses and of their mirror images.
    """

    tilt_deg: float
    depths_mm: FloatArray
    displacement: Array32
    force_n: FloatArray
    branch: tuple[str, ...]
    ended: str
    weights: Array32


@dataclass(frozen=True, eq=False)
class PressedDome:
    """Presses of one dome that differ by the tilt of the wall alone.

    Attributes
    ----------
    mesh
        What was pressed.
    presses
        (t,) by rising tilt; none of a dome at rest.
    depths_mm
        (d,) depths of rest, of every image step and of full depth.
    runs
        Weights (2, t) of the presses and of their mirror images at any tilt, for each depth.
    """

    mesh: Mesh
    presses: tuple[Press, ...]
    depths_mm: FloatArray
    runs: TiltRuns
    _fields: dict[bytes, MarkerField] = field(default_factory=dict)

    @property
    def tilts_deg(self) -> FloatArray:
        """(t,) solved tilts, rising."""
        return self.runs.tilts_deg

    @cached_property
    def mirrored(self) -> NDArray[np.intp]:
        """(n,) for each node the one across y = 0."""
        distance, mirrored = cKDTree(self.mesh.nodes).query(self.mesh.nodes * [1.0, -1.0, 1.0])
        if distance.max() > SAME_MM:
            raise PalpateError("The mesh is not symmetric about y = 0.", "Solve the presses again with this version.")
        return np.asarray(mirrored)

    @cached_property
    def displacement(self) -> Array32:
        """(d, t, n, 3) mm of the mesh's nodes; zero where a press ended before."""
        moved = [press.displacement for press in self.presses]
        return self._gather(moved, *self.mesh.nodes.shape).astype(np.float32)

    @cached_property
    def force_n(self) -> FloatArray:
        """(d, t) norm of the wall's force; zero where a press ended before."""
        return self._gather([np.linalg.norm(press.force, axis=1) for press in self.presses])

    @cached_property
    def stress_mpa(self) -> Array32:
        """(d, t, n, 1) von Mises Cauchy stress in MPa of the presses, zero at rest; takes about a second to find."""
        stress = [np.nan_to_num(nodal_von_mises(press))[..., None] for press in self.presses]
        return self._gather(stress, len(self.mesh.nodes), 1).astype(np.float32)

    def at(self, tilt_deg: float) -> SurfaceMotion:
        """The press at a tilt (degrees) between the least and the greatest that were solved.

        Raises
        ------
        PalpateError
            If the tilt is not finite or beyond them.
        """
        first, last = float(self.tilts_deg[0]), float(self.tilts_deg[-1])
        if not first - SAME_DEG <= tilt_deg <= last + SAME_DEG:
            raise PalpateError(f"{tilt_deg:g}° was not pressed.", f"Choose a tilt from {first:g} to {last:g}°.")
        tilt = np.array([tilt_deg], float)
        found = [next(self.runs.read(tilt, image), None) for image in range(len(self.depths_mm))]
        deep = next((k for k, item in enumerate(found) if item is None), len(found))
        weights = np.concatenate([item[1] for item in found[:deep] if item is not None]).astype(np.float32)
        return SurfaceMotion(
            tilt_deg=float(tilt_deg),
            depths_mm=self.depths_mm[:deep],
            displacement=self.blend(self.displacement, weights),
            force_n=np.maximum((weights.sum(axis=1) * self.force_n[:deep]).sum(axis=1), 0.0),
            branch=tuple(str(self.runs.labels(tilt, image)[0][0]) for image in range(deep)),
            ended=str(self.runs.labels(tilt, deep)[1][0]) if deep < len(found) else self._end(tilt_deg),
            weights=weights,
        )

    def markers(self, layout: MarkerLayout, motion: SurfaceMotion, azimuth_deg: float) -> FloatArray:
        """Deformed positions (k, m, 3) mm of a layout's markers, dome's frame, at every depth of a motion.

        Parameters
        ----------
        layout
            Undeformed markers (m, 3) mm.
        motion
            A press of this dome.
        azimuth_deg
            Direction of the wall's rotation axis.

        Raises
        ------
        PalpateError
            If the azimuth is not finite, or a marker is not on the dome.
        """
        if not np.isfinite(azimuth_deg):
            raise PalpateError(f"The azimuth {azimuth_deg} is no angle.", "Give degrees.")
        if not self.presses:
            return np.broadcast_to(layout.positions, (len(motion.depths_mm), *layout.positions.shape))
        name = layout.positions.tobytes()
        if name not in self._fields:
            self._fields[name] = build_field(self.presses, layout, self.depths_mm)
        rx, ry = rotation_vector(motion.tilt_deg, np.radians([azimuth_deg])).T
        return np.concatenate([self._fields[name].positions(rx, ry, k) for k in range(len(motion.depths_mm))])

    def stress(self, motion: SurfaceMotion) -> Array32:
        """Von Mises stress (k, n) in MPa for a motion, interpolated like the displacement."""
        return self.blend(self.stress_mpa, motion.weights)[..., 0].clip(min=0.0)

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

    def _end(self, tilt_deg: float) -> str:
        """Why the press next to a tilt that ended first goes no deeper."""
        neighbours = self.runs.neighbours(tilt_deg)
        if not self.presses:
            return self.runs.ended[neighbours[0]]
        return str(min((self.presses[n] for n in neighbours), key=lambda press: press.ended_depth).ended)


def gather_presses(presses: Sequence[Press]) -> PressedDome:
    """Gather the presses of one dome for interpolation.

    Parameters
    ----------
    presses
        At least one, of one half mesh and one image step.

    Raises
    ------
    PalpateError
        If there is none, they differ by more than the tilt, or the whole dome was meshed.
    """
    if not presses:
        raise PalpateError("There is no press to show.", "Run the study first.")
    presses = tuple(sorted(presses, key=lambda press: press.wall.radial))
    mesh = presses[0].mesh
    mesh.skin.require_revolution(
        "its presses are not drawn",
        "Write single presses for ParaView: `palpate press --export FOLDER`.",
    )
    mesh = mesh_skin(mesh.skin, mesh.spec)  # each press has its pole elsewhere
    if any(press.mesh.spec != mesh.spec or press.mesh.skin != mesh.skin for press in presses):
        raise PalpateError("The presses are not of one dome and mesh.", "Give presses that differ by the tilt alone.")
    if mesh.spec.whole:
        raise PalpateError("Presses of a whole dome are not drawn.", "Press half of it: mesh: {whole: false}.")
    depths = _depths(presses)
    tilts = np.array([press.wall.radial for press in presses], float)
    runs = _weigh(tilts, label_presses(presses, depths), [str(press.ended) for press in presses])
    return PressedDome(mesh, tuple(press.on(mesh) for press in presses), depths, runs)


def rest_dome(mesh: Mesh, tilt_deg: float = 0.0) -> PressedDome:
    """A dome that was never pressed, as a press of no depth by a wall of a tilt (degrees)."""
    runs = _weigh(np.array([tilt_deg]), np.full((1, 1), "flat", dtype="U16"), ["not pressed yet"])
    return PressedDome(mesh, (), np.zeros(1), runs)


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
    ends = presses[0].depth if len(presses) == 1 else np.array([press.wall.depth for press in presses])
    depths: FloatArray = np.unique(np.round(np.concatenate([[0.0], images, ends[ends <= reached]]), 6))
    return depths
