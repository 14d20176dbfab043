"""Drawable skin at any pose of the wall: surface, markers and force, interpolated as in a dataset.

All of them are read from the `palpate.surrogate.PressField` of the solved presses. Only the skin is drawn, so fields
are of its nodes, which are a mesh's first; a gel inside is left out.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

from palpate.camera import Camera
from palpate.core import BoolArray, FloatArray, PalpateError
from palpate.design import MarkerLayout, Symmetry, rotation_vector
from palpate.fea import Branch, Press, WallSpec, contact_traction, nodal_von_mises
from palpate.mesh import Mesh, locate_nodes, mesh_skin
from palpate.surrogate import PressField, Series, build_field, surface_displacement

Array32 = NDArray[np.float32]
_SAME_MM, _SAME_DEG = 1e-6, 1e-9
NODAL_FIELDS: dict[str, Callable[[Press], FloatArray]] = {
    "stress": nodal_von_mises,
    "pressure": lambda press: contact_traction(press).pressure,
}
"""Fields of the skin's colour (n, n_nodes), MPa: von Mises stress and contact pressure."""


@dataclass(frozen=True, eq=False)
class SurfaceMotion:
    """One press at one pose of the wall, from first contact to the maximum depth.

    Attributes
    ----------
    tilt_deg, azimuth_deg
        Tilt and azimuth of the wall; the azimuth is 0 if one motion is rotated to all of them.
    depths_mm
        (k,) depths, from 0.
    displacement
        (k, n, 3) mm of the nodes of the skin, without its gel.
    force_n
        (k,) norm of the wall's force.
    branch
        (k,) label of each depth.
    ended
        Reason of the end.
    normal, touch, way
        The wall's outward unit normal (3,), the point (3,) mm of first contact, and the unit vector (3,) against
        which the wall comes.
    """

    tilt_deg: float
    azimuth_deg: float
    depths_mm: FloatArray
    displacement: Array32
    force_n: FloatArray
    branch: tuple[str, ...]
    ended: str
    normal: FloatArray
    touch: FloatArray
    way: FloatArray


@dataclass(frozen=True, eq=False)
class VisibleMarkers:
    """Markers at one pose of the wall, at every depth.

    Attributes
    ----------
    positions
        (k, m, 3) mm, skin's frame.
    pixels
        (k, m, 2) px; NaN for one behind the camera.
    radius_px
        (k, m) approximate radius of the marker in the image.
    seen
        (k, m) whether the camera sees it.
    """

    positions: FloatArray
    pixels: FloatArray
    radius_px: FloatArray
    seen: BoolArray


@dataclass(frozen=True, eq=False)
class PressedSkin:
    """The presses of one skin, to be drawn.

    Attributes
    ----------
    mesh
        Mesh that is drawn, since the pole of each press's own mesh is elsewhere: half of a skin of revolution, one
        motion of which, turned about the axis, serves every azimuth; the whole of a skin with two mirrors.
    press_field
        The presses at any pose; `None` of a skin at rest.
    rest_tilt_deg
        Tilt of the wall before a skin at rest, degrees.
    """

    mesh: Mesh
    press_field: PressField | None
    rest_tilt_deg: float = 0.0
    _fields: dict[bytes, PressField] = field(default_factory=dict, kw_only=True)
    _series: dict[str, Series] = field(default_factory=dict, kw_only=True)

    @property
    def solved(self) -> tuple[Press, ...]:
        """The solved presses."""
        return () if self.press_field is None else self.press_field.presses

    @property
    def turned(self) -> bool:
        """Whether one motion, turned about the axis, serves every azimuth."""
        return not self.mesh.spec.whole

    @property
    def tilts_deg(self) -> FloatArray:
        """(t,) solved tilts, ascending."""
        return np.array([self.rest_tilt_deg]) if self.press_field is None else self.press_field.runs.tilts_deg

    @property
    def depths_mm(self) -> FloatArray:
        """(d,) depths, from 0."""
        return np.zeros(1) if self.press_field is None else self.press_field.depths_mm

    def nearest(self, tilt_deg: float, azimuth_deg: float) -> Press:
        """Return the solved press nearest to a pose of the wall (degrees); of a turned skin, nearest in tilt."""
        pose = rotation_vector(tilt_deg, np.radians(0.0 if self.turned else azimuth_deg))

        def distance(press: Press) -> float:
            azimuth = 0.0 if self.turned else np.radians(press.obstacle.turn_deg)
            return float(np.linalg.norm(rotation_vector(press.obstacle.radial, azimuth) - pose))

        return min(self.solved, key=distance)

    @cached_property
    def nodes(self) -> FloatArray:
        """(n, 3) mm nodes of the skin at rest, without its gel."""
        return self.mesh.nodes[: len(self.mesh.inner_disc)]

    def at(self, tilt_deg: float, azimuth_deg: float = 0.0) -> SurfaceMotion:
        """Return the press at a tilt (degrees) within the solved range, and at an azimuth.

        Raises
        ------
        PalpateError
            If the tilt is not finite or out of range, or the azimuth is not finite.
        """
        first, last = float(self.tilts_deg[0]), float(self.tilts_deg[-1])
        if not first - _SAME_DEG <= tilt_deg <= last + _SAME_DEG:
            raise PalpateError(
                f"{tilt_deg:g}° was not pressed.",
                f"Choose a tilt from {first:g} to {last:g}°.",
                code="tilt-not-pressed",
            )
        azimuth = 0.0 if self.turned else _finite(azimuth_deg)
        labels = self._labels(tilt_deg)
        deep = next((k for k, (branch, _) in enumerate(labels) if not branch), len(labels))
        obstacle = WallSpec() if self.press_field is None else self.press_field.presses[0].obstacle
        wall = obstacle.model_copy(update={"tilt_deg": float(np.clip(tilt_deg, first, last)), "azimuth_deg": azimuth})
        plane, touch = wall.at_first_contact(self.mesh)
        moved, force = np.zeros((deep, *self.nodes.shape)), np.zeros((deep, 3))
        if self.press_field is not None:
            moved, force = (
                self._read(each, tilt_deg, azimuth, deep) for each in (self._moved, self.press_field.force)
            )
        return SurfaceMotion(
            tilt_deg=float(tilt_deg),
            azimuth_deg=azimuth,
            depths_mm=self.depths_mm[:deep],
            displacement=moved.astype(np.float32),
            force_n=np.linalg.norm(force, axis=-1),
            branch=tuple(branch for branch, _ in labels[:deep]),
            ended=labels[deep][1] if deep < len(labels) else self._end(tilt_deg),
            normal=plane.gap(touch[None]).normal[0],
            touch=touch,
            way=wall.approach_axis(self.mesh),
        )

    def nodal_field(self, motion: SurfaceMotion, name: str) -> Array32:
        """One of `NODAL_FIELDS` (k, n) for a motion, interpolated like displacement; slow at first."""
        deep = len(motion.depths_mm)
        if self.press_field is None:
            return np.zeros((deep, len(self.nodes)), np.float32)
        if name not in self._series:
            self._series[name] = self.press_field.nodal(self.mesh, partial(_nodal_field, name), linear=False)
        found = self._read(self._series[name], motion.tilt_deg, motion.azimuth_deg, deep)
        return found[..., 0].clip(min=0.0).astype(np.float32)

    def positions(self, layout: MarkerLayout, motion: SurfaceMotion, azimuth_deg: float) -> FloatArray:
        """Deformed positions (k, m, 3) mm of a layout's markers, skin's frame, at every depth of a motion.

        Parameters
        ----------
        layout
            Undeformed markers (m, 3) mm.
        motion
            A press of this skin.
        azimuth_deg
            Direction of the wall's rotation axis: (rx, ry) = tilt (cos, sin).

        Raises
        ------
        PalpateError
            If the azimuth is not finite, or a marker is not on the skin.
        """
        azimuth = np.radians([_finite(azimuth_deg)])
        if self.press_field is None or not len(layout):
            return np.broadcast_to(layout.positions, (len(motion.depths_mm), *layout.positions.shape))
        name = layout.positions.tobytes()
        if name not in self._fields:
            self._fields[name] = self.press_field.with_markers(layout)
        rx, ry = rotation_vector(motion.tilt_deg, azimuth).T
        return np.concatenate([self._fields[name].positions(rx, ry, k) for k in range(len(motion.depths_mm))])

    def markers(
        self, layout: MarkerLayout, camera: Camera, motion: SurfaceMotion, azimuth_deg: float
    ) -> VisibleMarkers:
        """The markers of `positions`, and how a camera sees them."""
        positions = self.positions(layout, motion, azimuth_deg)
        distance = np.linalg.norm(positions - camera.origin, axis=-1)
        radius = camera.spec.fx_px * layout.diameter / 2.0 / np.maximum(distance, 1e-3)
        seen = camera.visible(positions, self.mesh.skin)
        return VisibleMarkers(positions, camera.project(positions), radius, seen)

    @cached_property
    def _moved(self) -> Series:
        assert self.press_field is not None
        return self.press_field.nodal(self.mesh, surface_displacement, linear=True)

    def _read(self, series: Series, tilt_deg: float, azimuth_deg: float, deep: int) -> FloatArray:
        """A quantity (k, …) at the first depths of a pose."""
        tilt, azimuth = np.array([tilt_deg]), np.radians([azimuth_deg])
        return np.concatenate([series.at(tilt, azimuth, k) for k in range(deep)])

    def _labels(self, tilt_deg: float) -> list[tuple[str, str]]:
        """Branch of a tilt at each depth, and the reason if it has no branch."""
        if self.press_field is None:
            return [(str(Branch.FLAT), "")]
        labels = (self.press_field.labels(np.array([tilt_deg]), k) for k in range(len(self.depths_mm)))
        return [(str(branch[0]), str(reason[0])) for branch, reason in labels]

    def _end(self, tilt_deg: float) -> str:
        """Reason why the presses next to a tilt go no deeper: that of the one that ended first."""
        if self.press_field is None:
            return "not pressed yet"
        runs = self.press_field.runs
        known = (runs.branch != "").sum(axis=0)
        return runs.ended[min(runs.neighbours(tilt_deg), key=lambda number: known[number])]


def build_pressed_skin(presses: Sequence[Press]) -> PressedSkin:
    """Interpolate the presses of one skin to be drawn.

    Parameters
    ----------
    presses
        At least one, of one mesh and depth step: of half a skin of revolution one a tilt, of a skin with two mirrors
        one at every azimuth of each tilt.

    Raises
    ------
    PalpateError
        If there is no press, they differ by more than the pose of a wall, or the skin has neither symmetry or, of
        revolution, was meshed whole.
    """
    if not presses:
        raise PalpateError("There is no press to show.", "Run the study first.", code="presses-none")
    first = presses[0]
    skin, spec = first.mesh.skin, first.mesh.spec.model_copy(update={"whole": False})
    if not first.obstacle.pose_space.is_tilt:
        raise PalpateError(
            f"Presses by other than walls are not drawn: {first.obstacle.label}.",
            "Write single presses for ParaView: `palpate press --export FOLDER`.",
            code="obstacle-not-drawn",
        )
    if any(
        press.mesh.spec.model_copy(update={"whole": False}) != spec or press.mesh.skin != skin for press in presses
    ):
        raise PalpateError(
            "The presses are not of one skin and mesh.",
            "Give presses that differ by the pose alone.",
            code="presses-designs-differ",
        )
    if skin.symmetry is Symmetry.REVOLVED and any(press.mesh.spec.whole for press in presses):
        raise PalpateError(
            "Presses of a whole dome are not drawn.",
            "Press half of it: mesh: {whole: false}.",
            code="mesh-half-needed",
        )
    depths = build_field(presses).depths_mm
    reached = max(float(press.depth.max()) for press in presses) + _SAME_MM
    # the depth at which a press ended early is an increment of it alone; full depth is one of all that came so far
    ends = presses[0].depth if len(presses) == 1 else np.array([press.obstacle.depth for press in presses])
    ends = np.unique(np.round([0.0, *ends[ends <= reached]], 6))
    apart = np.abs(ends[:, None] - depths).min(axis=1, initial=np.inf)
    depths = np.sort(np.concatenate([depths, ends[apart > _SAME_MM]]))
    mesh = mesh_skin(skin, spec.model_copy(update={"whole": skin.symmetry is Symmetry.MIRRORED}))
    return PressedSkin(mesh, build_field(presses, depths_mm=depths))


def _nodal_field(name: str, press: Press, mesh: Mesh) -> FloatArray:
    """One of `NODAL_FIELDS` (i, n, 1) of a press at the nodes of another mesh of its skin; 0 at rest."""
    values = np.nan_to_num(NODAL_FIELDS[name](press))[..., None]
    return locate_nodes(press.mesh, mesh).interpolate(values)


def _finite(azimuth_deg: float) -> float:
    if not np.isfinite(azimuth_deg):
        raise PalpateError(f"The azimuth {azimuth_deg} is no angle.", "Give degrees.", code="azimuth-not-finite")
    return float(azimuth_deg)
