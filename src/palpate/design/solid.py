"""Solids by a CAD kernel: revolved, lofted, joined and cut; measured, meshed and written.

Only this file uses the kernel (build123d on Open CASCADE). It is loaded when the first solid is made; its absence is
a `MissingExtraError`. A solid is immutable; every method returns a new one. Lengths in mm, angles in degrees.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from palpate.core import FloatArray, IntArray, PalpateError, load_extra, provenance
from palpate.design.outline import Arc, Outline, Plan, Point, SmoothCurve

_LINEAR_MM, _ANGULAR_RAD = 0.02, 0.1
"""Maximum distance and angle between a mesh and its solid. By hand."""
_FINER = (1.0, 2.0, 4.0, 8.0)
"""Factors by which both are divided until the volume is accurate; smooth curves need more than arcs."""
_VOLUME = 2e-3
"""Maximum relative volume error of a mesh. By hand."""
_MERGE_MM = 1e-6
"""Distance up to which two points are one, mm."""
_CURVE_POINTS = 120
"""Points of a curved edge of an outline. By hand."""
_QUARTER, _BENDS = 33, 9
"""Points per quarter of a plan, and sections of a bent edge of an outline, for smooth curves. By hand."""
_AUTHOR = re.compile(rb"\(\s*'Author'\s*\)\s*,\s*\(\s*'Open CASCADE'\s*\)")
"""Author and organisation in the header of a STEP file, as the kernel writes them."""
_INTEGRAL = 1e-7
"""Relative error at which the refinement of a volume integral ends. By hand."""


@dataclass(frozen=True)
class SurfaceMesh:
    """Points (n, 3) mm and triangles (m, 3) of a solid's surface, counter-clockwise seen from outside."""

    points: FloatArray
    triangles: IntArray

    @property
    def volume(self) -> float:
        """Enclosed volume, mm³, by the divergence theorem; negative if the triangles face inward."""
        a, b, c = np.moveaxis(self.points[self.triangles], 1, 0)
        return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)

    @property
    def is_watertight(self) -> bool:
        """Whether every edge belongs to exactly two triangles, with opposite directions."""
        edges = np.concatenate([self.triangles[:, [k, (k + 1) % 3]] for k in range(3)]).astype(np.int64)
        forward, back = (np.sort(one * len(self.points) + other) for one, other in (edges.T, edges.T[::-1]))
        return bool((np.diff(forward) > 0).all() and np.array_equal(forward, back))

    def welded(self, tolerance: float = _MERGE_MM) -> SurfaceMesh:
        """Merge points closer than `tolerance` mm, and remove degenerate triangles and unused points.

        The kernel repeats the pole of a face of revolution, and triangles there have no area.
        """
        grid = np.round(self.points / tolerance)
        _, first, number = np.unique(grid, axis=0, return_index=True, return_inverse=True)
        triangles = number.reshape(-1)[self.triangles]
        distinct = (triangles != np.roll(triangles, 1, axis=1)).all(axis=1)
        used, triangles = np.unique(triangles[distinct], return_inverse=True)
        return SurfaceMesh(self.points[first][used], triangles.reshape(-1, 3).astype(np.int64))

    def turned(self, rotation: FloatArray) -> SurfaceMesh:
        """Rotate the mesh by (3, 3) and place it on z = 0."""
        points = self.points @ rotation.T
        return SurfaceMesh(points - [0.0, 0.0, points[:, 2].min()], self.triangles)


@dataclass(frozen=True)
class CadSolid:
    """One body, with its shape of the CAD kernel."""

    shape: Any

    @cached_property
    def volume(self) -> float:
        """Volume, mm³."""
        return _volume(self.shape)

    @cached_property
    def bounds(self) -> FloatArray:
        """Minimum and maximum coordinates (2, 3), mm."""
        box = self.shape.bounding_box()
        return np.array([tuple(box.min), tuple(box.max)])

    @property
    def pieces(self) -> int:
        """Number of separate bodies."""
        return len(self.shape.solids())

    def join(self, *others: CadSolid) -> CadSolid:
        """Unite with further solids."""
        return CadSolid(self.shape.fuse(*(other.shape for other in others)).clean())

    def cut(self, *others: CadSolid) -> CadSolid:
        """Subtract further solids."""
        return CadSolid(self.shape.cut(*(other.shape for other in others)))

    def overlap(self, other: CadSolid) -> float:
        """Return the volume shared with another solid, mm³."""
        return sum(_volume(body) for body in self._shared(other))

    def common(self, other: CadSolid) -> CadSolid:
        """Return the intersection with another solid."""
        shared = self._shared(other)
        if len(shared) != 1:
            raise PalpateError(
                f"Two solids share {len(shared)} bodies instead of one.",
                "Check the dimensions.",
                code="solids-not-joined",
            )
        return CadSolid(shared[0])

    def _shared(self, other: CadSolid) -> list[Any]:
        shared = self.shape.intersect(other.shape)
        return list(shared.solids()) if shared else []

    def distance(self, other: CadSolid) -> float:
        """Return the minimum distance to another solid, mm; zero if they touch."""
        return float(self.shape.distance_to(other.shape))

    def moved(self, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> CadSolid:
        """Move the solid."""
        cad = _cad()
        return CadSolid(self.shape.moved(cad.Location((x, y, z))))

    def turned(self, axis: str, angle_deg: float) -> CadSolid:
        """Rotate the solid about the axis x, y or z."""
        cad = _cad()
        return CadSolid(self.shape.rotate(getattr(cad.Axis, axis.upper()), angle_deg))

    def look(self, origin: Sequence[float]) -> list[FloatArray]:
        """Return the visible lines from a distant `origin` (3,) mm: polylines (n, 2) mm, z upward."""
        visible, _ = self.shape.project_to_viewport(tuple(origin), viewport_up=(0, 0, 1))
        lines = []
        for edge in visible:
            count = 2 if edge.geom_type == _cad().GeomType.LINE else _CURVE_POINTS
            points = np.array([tuple(edge.position_at(share)) for share in np.linspace(0, 1, count)])
            lines.append(points[:, :2])
        return lines

    def mesh(self) -> SurfaceMesh:
        """Mesh the surface: watertight, facing outward, within 0.2 % of the volume.

        Raises
        ------
        PalpateError
            If no such mesh is found.
        """
        mesher = load_extra("OCP.BRepMesh", "cad").BRepMesh_IncrementalMesh
        for finer in _FINER:
            # build123d's own call takes the distance as a share of every edge's length: 0.3 mm on a barrel
            mesher(self.shape.wrapped, _LINEAR_MM / finer, False, _ANGULAR_RAD / finer)
            points, triangles = self.shape.tessellate(_LINEAR_MM / finer, _ANGULAR_RAD / finer)
            mesh = SurfaceMesh(np.array([tuple(point) for point in points]), np.array(triangles, np.int64)).welded()
            if mesh.is_watertight and abs(mesh.volume / self.volume - 1) <= _VOLUME:
                return mesh
        raise PalpateError(
            f"The mesh of a solid is open or its volume wrong: {mesh.volume:.6g} instead of {self.volume:.6g} mm³.",
            "Change a dimension by some hundredths of a millimetre, and report this.",
            code="solid-mesh-open",
        )


def revolve(outline: Outline) -> CadSolid:
    """Revolve an outline of (x, z), x >= 0, about the z axis."""
    cad = _cad()
    return CadSolid(cad.revolve(_face(outline, lambda point: (point[0], 0.0, point[1])), axis=cad.Axis.Z))


def loft(outline: Outline, plan: Plan) -> CadSolid:
    """Sweep an outline of (x, z) around a plan of places w(φ): each point traces ``(x w(φ), z)``.

    For the unit circle use `revolve`, which is exact; this function interpolates by smooth curves.

    Raises
    ------
    PalpateError
        If the outline meets the axis at an angle, or is not closed.
    """
    cad = _cad()
    faces: list[Any] = []
    for edge in _edges(outline, lambda point: (point[0], 0.0, point[1])):
        bent = edge.geom_type != cad.GeomType.LINE
        at = np.array([tuple(edge.position_at(share)) for share in np.linspace(0, 1, _BENDS if bent else 2)])[:, ::2]
        if at[:, 0].max() <= _MERGE_MM:
            continue
        if not bent and abs(at[0, 1] - at[1, 1]) <= _MERGE_MM:
            inner, outer = sorted(at.tolist())
            faces.append(cad.Face(_ring(plan, outer), [_ring(plan, inner)] if inner[0] > _MERGE_MM else []))
            continue
        if at[:, 0].min() <= _MERGE_MM:
            raise PalpateError(
                "An outline meets the axis at an angle; no plan can close it there.",
                "Begin it with a flat.",
                code="outline-leaves-axis-aslant",
            )
        faces += cad.Shell.make_loft([_ring(plan, place) for place in at.tolist()], ruled=not bent).faces()
    shells = cad.Face.sew_faces(faces)
    if len(shells) != 1:
        raise PalpateError(
            f"A solid has {len(shells)} shells instead of one.",
            "Check that the outline is closed.",
            code="solid-in-several-shells",
        )
    return CadSolid(cad.Solid(cad.Shell(shells[0])))


def _ring(plan: Plan, at: Sequence[float]) -> Any:
    """Return a plan of a width and a height, (x, z), as a wire of four splines."""
    cad = _cad()
    wide, height = at
    edges = []
    for first in np.arange(4) * np.pi / 2:
        angles = np.linspace(first, first + np.pi / 2, _QUARTER)
        places, slopes = plan(angles)[:2]
        points = [(*(wide * place).tolist(), height) for place in places]
        ends = [(*(wide * slopes[end]).tolist(), 0.0) for end in (0, -1)]
        edges.append(cad.Edge.make_spline(points, tangents=ends, parameters=angles.tolist(), scale=False))
    return cad.Wire(edges)


def extrude(outline: Outline, height: float) -> CadSolid:
    """Extrude an outline of (x, y) from z = 0 to `height`, downward if negative."""
    cad = _cad()
    face = _face(outline, lambda point: (point[0], point[1], 0.0))
    return CadSolid(cad.extrude(face, amount=height, dir=(0, 0, 1)))


def cylinder(radius: float, low: float, high: float, at: Point = (0.0, 0.0)) -> CadSolid:
    """Return a cylinder along z about `at` (x, y), from z = `low` to `high`."""
    cad = _cad()
    return CadSolid(cad.Solid.make_cylinder(radius, high - low, cad.Plane((*at, low))))


def box(low: Sequence[float], high: Sequence[float]) -> CadSolid:
    """Return a box between two corners (3,) mm."""
    cad = _cad()
    size = np.subtract(high, low)
    return CadSolid(cad.Solid.make_box(*(float(value) for value in size), cad.Plane(tuple(map(float, low)))))


def gather(parts: Sequence[CadSolid]) -> CadSolid:
    """Combine several solids, unchanged, for display."""
    return CadSolid(_cad().Compound([body for part in parts for body in part.shape.solids()]))


def write_step(path: Path, name: str, parts: dict[str, CadSolid]) -> None:
    """Write named parts as one assembly, in mm; the author of the file is the program."""
    cad = _cad()
    children = []
    for label, solid in parts.items():
        bodies = solid.shape.solids()
        child = bodies[0] if len(bodies) == 1 else cad.Compound(children=bodies)
        child.label = label
        children.append(child)
    memory = io.BytesIO()  # of a full disk the library says no more than that it failed
    with _silent():
        cad.export_step(cad.Compound(label=name, children=children), memory, unit=cad.Unit.MM)
    author = f"('palpate {provenance()['palpate']}'),('')"
    path.write_bytes(_AUTHOR.sub(author.encode(), memory.getvalue(), count=1))


def read_step(path: Path) -> dict[str, CadSolid]:
    """Read the named parts of an assembly."""
    with _silent():
        whole = _cad().import_step(path)
    return {child.label: CadSolid(child) for child in whole.children}


def _face(outline: Outline, place: Any) -> Any:
    cad = _cad()
    return cad.Face(cad.Wire(_edges(outline, place)))


def _edges(outline: Outline, place: Any) -> list[Any]:
    """Return the edges of a closed outline in order."""
    cad = _cad()
    first = outline[0]
    if isinstance(first, Arc | SmoothCurve):
        raise PalpateError(
            "An outline begins with an arc or a curve.", "Begin it with a point.", code="outline-begins-with-curve"
        )
    edges, here = [], first
    for item in [*outline[1:], first]:
        end = item.end if isinstance(item, Arc | SmoothCurve) else item
        if isinstance(item, Arc):
            edges.append(cad.Edge.make_three_point_arc(place(here), place(item.through), place(end)))
        elif isinstance(item, SmoothCurve):
            edges.append(cad.Edge.make_spline([place(point) for point in (here, *item.through)]))
        elif np.hypot(end[0] - here[0], end[1] - here[1]) > _MERGE_MM:
            edges.append(cad.Edge.make_line(place(here), place(end)))
        here = end
    return edges


def _volume(shape: Any) -> float:
    """Return the volume, mm³.

    The kernel's plain integral is wrong by up to 5 % for lofted solids, its refined one by 1e-5 for revolved splines.
    """
    spline = _cad().GeomType.BSPLINE
    if all(face.geom_type != spline for face in shape.faces()):
        return float(shape.volume)
    found = load_extra("OCP.GProp", "cad").GProp_GProps()
    load_extra("OCP.BRepGProp", "cad").BRepGProp.VolumeProperties_s(shape.wrapped, found, _INTEGRAL, False, False)
    return float(found.Mass())


def _cad() -> Any:
    return load_extra("build123d", "cad")


@contextlib.contextmanager
def _silent() -> Iterator[None]:
    """Suppress the kernel's output to the terminal, written by C++."""
    with Path(os.devnull).open("w") as nothing, contextlib.redirect_stdout(nothing):
        yield
