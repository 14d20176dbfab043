"""Domain randomisation: markers of units that deviate from the design.

Every virtual press is that of another unit, under the obstacle of the study or a further one. With fields u of the
presses of the design, of walls with friction µ_k, of a thinner and a thicker dome and of a further obstacle j, a
unit's displacement is

    u = u_0 + (1 - a) (u_k - u_0) + a (u_k+1 - u_0) + b (u_± - u_0) + (u_j - u_0),      0 ≤ a, b ≤ 1

that is, linear between neighbouring frictions (no slip, if the design has it, is next to the largest) and from the
design's thickness to the thinner or thicker one. A misprinted marker moves with the surface, to first order in its
displacement δ along two tangents t_i:  u(p + δ) = u(p) + Σ δ_i (u(p + h t_i) - u(p)) / h.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from palpate.camera import Camera, build_camera
from palpate.core import FloatArray, PalpateError, TextArray, generator
from palpate.datasets.poses import sample_poses
from palpate.datasets.spec import DatasetSpec, RandomisationSpec
from palpate.design import MarkerLayout
from palpate.fea import Press
from palpate.surrogate import PressField, build_field

_STEP = 0.2
"""Distance h of the points by which the motion of the surface near a marker is differentiated, mm.
By hand."""


@dataclass(frozen=True)
class PerturbedPresses:
    """Presses of units that differ from the design.

    Attributes
    ----------
    frictions
        Presses of the design with each of `RandomisationSpec.frictions`, in that order.
    thicknesses
        Presses of a thinner and of a thicker wall, or none.
    obstacles
        Presses of the design by each of `RandomisationSpec.obstacles`, in that order.
    """

    frictions: tuple[Sequence[Press], ...] = ()
    thicknesses: tuple[Sequence[Press], ...] = ()
    obstacles: tuple[Sequence[Press], ...] = ()

    @property
    def groups(self) -> tuple[Sequence[Press], ...]:
        """All of them, in this order."""
        return (*self.frictions, *self.thicknesses, *self.obstacles)

    @property
    def count(self) -> int:
        """Number of presses."""
        return sum(len(group) for group in self.groups)


@dataclass(frozen=True, eq=False)
class RandomisedField:
    """Positions of the markers of another unit for every virtual press.

    Attributes
    ----------
    base
        The design.
    others
        Frictions by descending coefficient, then thicknesses, then obstacles.
    weights
        (n presses, len(others)) share of each other's difference from the base.
    tangent_fields
        Fields of markers displaced along two tangents by `_STEP`; empty if the print is exact.
    tangent_offsets
        (n presses, m, 2) displacement of each marker along them, mm.
    """

    base: PressField
    others: tuple[PressField, ...]
    weights: FloatArray
    tangent_fields: tuple[PressField, ...]
    tangent_offsets: FloatArray

    @property
    def rest(self) -> FloatArray:
        """(m, 3) markers of the undeformed design, mm."""
        return self.base.rest

    def labels(self, rotations: FloatArray, depth_index: int) -> tuple[TextArray, TextArray]:
        """Return the branch of every virtual press at one depth, or a reason; see `PressField.labels`."""
        tilt = np.hypot(rotations[:, 0], rotations[:, 1])
        branch, reason = self.base.labels(tilt, depth_index)
        for weight, other in zip(self.weights.T, self.others, strict=True):
            its_branch, its_reason = other.labels(tilt, depth_index)
            apart = (weight > 0) & (its_branch != branch) & (branch != "")
            reason[apart] = np.where(its_reason[apart] != "", its_reason[apart], "units on different branches")
            branch[apart] = ""
        return branch, reason

    def rest_of(self, rows: NDArray[np.intp]) -> FloatArray:
        """(k, m, 3) markers at rest of the virtual presses `rows`, mm."""
        if not self.tangent_fields:
            return np.broadcast_to(self.rest, (len(rows), *self.rest.shape))
        return self.rest + self._aside(rows, [field.rest for field in self.tangent_fields], self.rest)

    def positions(self, rotations: FloatArray, rows: NDArray[np.intp], depth_index: int) -> FloatArray:
        """(k, m, 3) deformed markers of the virtual presses `rows` at one depth, mm."""
        rx, ry = rotations[rows].T
        base = self.base.positions(rx, ry, depth_index)
        moved = self._mix(base, rows, lambda other, used: other.positions(rx[used], ry[used], depth_index))
        if self.tangent_fields:
            moved += self._aside(rows, [field.positions(rx, ry, depth_index) for field in self.tangent_fields], base)
        return moved

    def forces(self, rotations: FloatArray, rows: NDArray[np.intp], depth_index: int) -> FloatArray:
        """(k, 3) N on the wall, skin's frame, in the virtual presses `rows` at one depth."""
        rx, ry = rotations[rows].T
        base = self.base.forces(rx, ry, depth_index)
        return self._mix(base, rows, lambda other, used: other.forces(rx[used], ry[used], depth_index))

    def _mix(
        self,
        base: FloatArray,
        rows: NDArray[np.intp],
        read: Callable[[PressField, NDArray[np.intp]], FloatArray],
    ) -> FloatArray:
        """A quantity (k, …) of the units in the virtual presses `rows`; `read` reads another field."""
        mixed = base.copy()
        for weight, other in zip(self.weights[rows].T, self.others, strict=True):
            used = np.flatnonzero(weight)
            mixed[used] += weight[used].reshape(-1, *[1] * (base.ndim - 1)) * (read(other, used) - base[used])
        return mixed

    def _aside(self, rows: NDArray[np.intp], tangent_fields: Sequence[FloatArray], base: FloatArray) -> FloatArray:
        steps = zip(np.moveaxis(self.tangent_offsets[rows], -1, 0), tangent_fields, strict=True)
        return np.asarray(sum(off[..., None] * (points - base) / _STEP for off, points in steps))


def randomise_field(
    presses: Sequence[Press], layout: MarkerLayout, relatives: PerturbedPresses, spec: DatasetSpec
) -> RandomisedField:
    """Draw a unit for each virtual press.

    Parameters
    ----------
    presses, layout
        The design's.
    relatives
        Presses of deviating units.
    spec
        Seed and deviations.

    Raises
    ------
    PalpateError
        If the presses for a friction, thickness or obstacle are missing, or have other depths than the design's.
    """
    chosen, base = spec.randomise or RandomisationSpec(), build_field(presses, layout)
    _refuse_missing(chosen, relatives)
    others = tuple(build_field(group, layout) for group in relatives.groups)
    for other in others:
        if len(other.depths_mm) != len(base.depths_mm) or not np.allclose(other.depths_mm, base.depths_mm):
            raise PalpateError(
                f"Presses of another friction, thickness or obstacle end at {other.depths_mm.max(initial=0.0):g} mm, "
                f"the design's at {base.depths_mm.max(initial=0.0):g} mm.",
                "Press less deep, or vary less.",
                code="dataset-variation-short",
            )
    count = len(sample_poses(spec, base.max_offset))
    size = (count, len(base.rest), 2) if chosen.dot else (count, 0, 2)
    off = chosen.dot * generator(spec.seed, "dot").uniform(-1.0, 1.0, size)
    return RandomisedField(
        base, others, _draw_weights(chosen, spec.seed, count), _tangent_fields(layout, presses, chosen), off
    )


def _draw_weights(spec: RandomisationSpec, seed: int, count: int) -> FloatArray:
    """Return the share of each relative in every virtual press, (count, relatives)."""
    frictions, obstacles = len(spec.frictions), len(spec.obstacles)
    weights = np.zeros((count, frictions + (2 if spec.thickness else 0) + obstacles))
    if frictions:
        place = generator(seed, "friction").uniform(0.0, frictions, count)  # 0: the design's contact
        knots = np.arange(1, frictions + 1)
        weights[:, :frictions] = np.maximum(1.0 - np.abs(place[:, None] - knots), 0.0)
    if spec.thickness:
        thick = generator(seed, "thickness").uniform(-1.0, 1.0, count)
        weights[:, frictions] = np.maximum(-thick, 0.0)
        weights[:, frictions + 1] = np.maximum(thick, 0.0)
    if obstacles:
        chosen = generator(seed, "obstacle").integers(0, obstacles + 1, count)  # 0: the study's obstacle
        weights[:, -obstacles:] = chosen[:, None] == np.arange(1, obstacles + 1)
    return weights


def randomise_camera(camera: Camera, spec: RandomisationSpec, seed: int, press: int) -> Camera:
    """The camera under the unit of one virtual press."""
    rng, nominal = generator(seed, "camera", press), camera.spec
    ways = dict(zip(("offset_x", "offset_y", "tilt_x_deg", "tilt_y_deg"), rng.uniform(-1.0, 1.0, 4), strict=True))
    sizes = {"offset": spec.camera_offset, "tilt": spec.camera_tilt_deg}
    values = {name: getattr(nominal, name) + sizes[name.split("_")[0]] * float(way) for name, way in ways.items()}
    values["distance"] = nominal.distance + spec.camera_distance * float(rng.uniform(-1.0, 1.0))
    scale = 1.0 + spec.focal * float(rng.uniform(-1.0, 1.0))
    values |= {"fx_px": nominal.fx_px * scale, "fy_px": nominal.fy_px * scale}
    return build_camera(nominal.model_copy(update=values))


def _refuse_missing(spec: RandomisationSpec, relatives: PerturbedPresses) -> None:
    wanted: Mapping[str, tuple[int, int]] = {
        "friction": (len(spec.frictions), len(relatives.frictions)),
        "thickness": (2 if spec.thickness else 0, len(relatives.thicknesses)),
        "obstacle": (len(spec.obstacles), len(relatives.obstacles)),
    }
    for name, (needed, given) in wanted.items():
        if needed != given:
            raise PalpateError(
                f"The dataset varies the {name} by {needed} more sets of presses, but {given} were given.",
                "Press them first; `palpate run` does so by itself.",
                code="dataset-variation-missing",
            )


def _tangent_fields(
    layout: MarkerLayout, presses: Sequence[Press], spec: RandomisationSpec
) -> tuple[PressField, ...]:
    """Return the fields of markers displaced along the meridian and along the circle."""
    if not spec.dot:
        return ()
    skin = presses[0].mesh.skin
    _, along, around = skin.tangents(layout.positions)
    moved = [skin.nearest(layout.positions + _STEP * tangent) for tangent in (along, around)]
    return tuple(build_field(presses, replace(layout, positions=points)) for points in moved)
