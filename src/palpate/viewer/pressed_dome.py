"""A pressed dome for any tilt of the wall, interpolated between the presses that were solved.

The displacement u of the nodes lies in the frame whose y-z plane is the tilt plane, so one press serves every
azimuth. A wall tilted by −t is the wall tilted by t seen in the mirror y → −y, which continues u to negative tilts:

    u(x, y, z; −t) = M u(x, −y, z; t),      M = diag(1, −1, 1)

At each depth the tilts are cut into runs on one branch, as in `palpate.dataset.field`; a cubic spline through a run
is a weighted sum of its presses, and the weights are found once for a tilt. Nothing is interpolated across a jump.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree

from palpate.core import FloatArray, PalpateError, TextArray
from palpate.fea import Press
from palpate.mesh import Mesh

Array32 = NDArray[np.float32]

SAME_MM, SAME_DEG = 1e-6, 1e-9
_MIRROR_MM = 1e-6


@dataclass(frozen=True, eq=False)
class Motion:
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
    tilts_deg
        (t,) solved tilts, rising.
    depths_mm
        (d,) depths of rest and of every image step.
    displacement
        (d, t, n, 3) mm; zero where a press ended before.
    force_n
        (d, t) norm of the wall's force; zero where a press ended before.
    branch
        (d, t) labels; empty where a press ended before.
    ended, ended_mm
        (t,) why and at which depth each press ended.
    mirrored
        (n,) for each node the one across y = 0.
    """

    mesh: Mesh
    tilts_deg: FloatArray
    depths_mm: FloatArray
    displacement: Array32
    force_n: FloatArray
    branch: TextArray
    ended: tuple[str, ...]
    ended_mm: tuple[float, ...]
    mirrored: NDArray[np.intp]

    def at(self, tilt_deg: float) -> Motion:
        """The press at a tilt (degrees) between the least and the greatest that were solved.

        Raises
        ------
        PalpateError
            If the tilt is not finite or beyond them.
        """
        first, last = float(self.tilts_deg[0]), float(self.tilts_deg[-1])
        if not first - SAME_DEG <= tilt_deg <= last + SAME_DEG:
            raise PalpateError(f"{tilt_deg:g}° was not pressed.", f"Choose a tilt from {first:g} to {last:g}°.")
        found = [weigh_presses(self.tilts_deg, row, tilt_deg) for row in self.branch]
        deep = next((k for k, item in enumerate(found) if item is None), len(found))
        weights = np.array([item for item in found[:deep] if item is not None], np.float32)
        nearest = weights[:, 0].argmax(axis=1)
        return Motion(
            tilt_deg=float(tilt_deg),
            depths_mm=self.depths_mm[:deep],
            displacement=self.blend(self.displacement, weights),
            force_n=np.maximum((weights.sum(axis=1) * self.force_n[:deep]).sum(axis=1), 0.0),
            branch=tuple(str(label) for label in self.branch[np.arange(deep), nearest]),
            ended=self._reason(deep, tilt_deg),
            weights=weights,
        )

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

    def _reason(self, deep: int, tilt_deg: float) -> str:
        above = min(int(np.searchsorted(self.tilts_deg, tilt_deg - SAME_DEG)), len(self.tilts_deg) - 1)
        below = above if abs(self.tilts_deg[above] - tilt_deg) <= SAME_DEG else max(above - 1, 0)
        if deep < len(self.depths_mm) and all(self.branch[deep, below : above + 1]):
            return "between the flat and the inverted branch"
        return min(zip(self.ended_mm[below : above + 1], self.ended[below : above + 1], strict=True))[1]


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
    if any(press.mesh.spec != mesh.spec or press.mesh.dome != mesh.dome for press in presses):
        raise PalpateError("The presses are not of one dome and mesh.", "Give presses that differ by the tilt alone.")
    if mesh.spec.whole:
        raise PalpateError("Presses of a whole dome are not drawn.", "Press half of it: mesh: {whole: false}.")
    depths = _depths(presses)
    shape = (len(depths), len(presses))
    moved, force = np.zeros((*shape, *mesh.nodes.shape), np.float32), np.zeros(shape)
    branch = np.full(shape, "", dtype="U16")
    for t, press in enumerate(presses):
        depth, image = match_depths(depths, press)
        moved[depth, t] = press.displacement[image]
        force[depth, t] = np.linalg.norm(press.force[image], axis=1)
        branch[depth, t] = press.branch[image]
    return PressedDome(
        mesh=mesh,
        tilts_deg=np.array([press.wall.radial for press in presses], float),
        depths_mm=depths,
        displacement=moved,
        force_n=force,
        branch=branch,
        ended=tuple(str(press.ended) for press in presses),
        ended_mm=tuple(float(press.ended_depth) for press in presses),
        mirrored=_mirror(mesh),
    )


def rest_dome(mesh: Mesh, tilt_deg: float = 0.0) -> PressedDome:
    """A dome that was never pressed, as a press of no depth by a wall of a tilt (degrees)."""
    return PressedDome(
        mesh=mesh,
        tilts_deg=np.array([tilt_deg]),
        depths_mm=np.zeros(1),
        displacement=np.zeros((1, 1, *mesh.nodes.shape), np.float32),
        force_n=np.zeros((1, 1)),
        branch=np.full((1, 1), "flat", dtype="U16"),
        ended=("not pressed yet",),
        ended_mm=(0.0,),
        mirrored=_mirror(mesh),
    )


def _mirror(mesh: Mesh) -> NDArray[np.intp]:
    """For each node the one across y = 0."""
    distance, mirrored = cKDTree(mesh.nodes).query(mesh.nodes * [1.0, -1.0, 1.0])
    if distance.max() > _MIRROR_MM:
        raise PalpateError("The mesh is not symmetric about y = 0.", "Solve the presses again with this version.")
    return np.asarray(mirrored)


def weigh_presses(tilts_deg: FloatArray, branch: TextArray, tilt_deg: float) -> FloatArray | None:
    """Weights of the solved presses at one depth.

    Parameters
    ----------
    tilts_deg
        (t,) solved tilts, rising.
    branch
        (t,) their labels; empty where a press ended before this depth.
    tilt_deg
        The tilt wanted.

    Returns
    -------
    ndarray or None
        (2, t) weights of the presses and of their mirror images; `None` where no run holds the tilt.
    """
    starts = [0, *(np.flatnonzero(branch[1:] != branch[:-1]) + 1), len(tilts_deg)]
    for a, b in pairwise(starts):
        first, last = tilts_deg[a], tilts_deg[b - 1]
        if branch[a] and first - SAME_DEG <= tilt_deg <= last + SAME_DEG:
            weights = np.zeros((2, len(tilts_deg)))
            weights[:, a:b] = _spline_weights(tilts_deg[a:b], float(np.clip(tilt_deg, first, last)))
            return weights
    return None


def _spline_weights(tilts: FloatArray, tilt: float) -> FloatArray:
    """Weights (2, r) of a run and of its mirror image in the cubic spline through them."""
    count = len(tilts)
    if count == 1:
        return np.array([[1.0], [0.0]])
    mirrors = count - 1 if tilts[0] == 0.0 else 0
    places = np.concatenate([-tilts[:0:-1], tilts]) if mirrors else tilts
    weights = CubicSpline(places, np.eye(len(places)))(tilt)
    split = np.zeros((2, count))
    split[0] = weights[mirrors:]
    if mirrors:
        split[1, 1:] = weights[:mirrors][::-1]
    return split


def _depths(presses: Sequence[Press]) -> FloatArray:
    steps = {round(float(press.wall.image_step), 9) for press in presses}
    if len(steps) > 1:
        raise PalpateError(f"The presses have images every {sorted(steps)} mm.", "Give all of them one image step.")
    step = steps.pop()
    reached = max(float(press.depth.max()) for press in presses)
    images = step * np.arange(int((reached + SAME_MM) / step) + 1, dtype=float)
    # where a press ended early is an image of it alone; full depth is one of all that came so far
    ends = presses[0].depth if len(presses) == 1 else np.array([press.wall.depth for press in presses])
    every = np.concatenate([images, ends[ends <= reached + SAME_MM]])
    depths: FloatArray = np.unique(np.round(every, 6))
    return depths


def match_depths(depths: FloatArray, press: Press) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Numbers of the depths (d,) in mm that a press has, and of its images there; on the way down only."""
    down = len(press.depth) if not press.wall.unload else int(np.argmax(press.depth)) + 1
    depth, image = np.nonzero(np.abs(depths[:, None] - press.depth[None, :down]) <= SAME_MM)
    return depth, image
