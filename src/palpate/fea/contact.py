"""Contact of the outer surface with a rigid plane, integrated on the quadrature points of the outer faces.

With the penetration ``delta = n·(x - x_w)`` of a point (positive inside the wall) and its place in the plane
``s = (I - n n^T)(x - x_w)``, the contact energy per undeformed area is

    phi(delta) + psi(s - s0),    p = phi'(delta)

* ``phi`` is a penalty of stiffness ``eps`` that starts quadratically in force over the width ``w``:
  ``p = eps delta² / 2w`` up to ``delta = w`` and ``eps (delta - w/2)`` beyond, so that the tangent is continuous;
* ``psi`` is a spring ``eps_t`` from the place ``s0`` on the wall where the point touched it, limited to the
  traction ``mu p`` (a Huber potential; no slip is mu = infinity, frictionless mu = 0). Which points stick, where,
  and the limit ``mu p``, are held during a solve and corrected between solves, so every solve minimises a smooth
  energy and its tangent is symmetric (Wriggers, *Computational Contact Mechanics*, 2006, chapter 5). A point
  that touches anew slides in the first solve and then sticks where its path crossed the wall.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from palpate.core import BoolArray, FloatArray, IntArray, kernel
from palpate.fea.element import DOFS, System
from palpate.mesh import gauss_points, shape_quadrilateral

OUTER_FIRST = 18
"""First node of the outer face in a cell."""

FREE, STICK, SLIP = 0, 1, 2
"""State of a contact point."""


class ContactLaw(NamedTuple):
    """Numbers of the contact energy.

    Attributes
    ----------
    stiffness
        Normal penalty eps, MPa/mm.
    width
        Width w of its smooth start, mm.
    tangential_stiffness
        Spring eps_t, MPa/mm.
    friction
        Coefficient of friction mu: 0 frictionless, infinity no slip.
    """

    stiffness: float
    width: float
    tangential_stiffness: float
    friction: float


class Plane(NamedTuple):
    """A rigid plane.

    Attributes
    ----------
    normal
        (3,) unit normal, away from the body.
    point
        (3,) mm, a point that moves with the plane.
    """

    normal: FloatArray
    point: FloatArray


class Touch(NamedTuple):
    """Where the contact points stick, and how hard.

    Attributes
    ----------
    place
        (n_points, 3) mm: the place on the wall that each point sticks to.
    limit
        (n_points,) MPa greatest tangential traction; 0 for points that do not stick, infinite for no slip.
    hold
        (n_points,) MPa/mm spring that pulls a lifting point back to the wall (see `palpate.fea.hold`).
    """

    place: FloatArray
    limit: FloatArray
    hold: FloatArray


class ContactFaces(NamedTuple):
    """Tables of the outer faces in the kernels.

    Attributes
    ----------
    nodes
        (n_faces, 9) node numbers.
    cell
        (n_faces,) cell whose face zeta = +1 each one is.
    shape
        (n_q, 9) shape functions at the quadrature points.
    weight
        (n_faces, n_q) mm² undeformed area of each point.
    """

    nodes: IntArray
    cell: IntArray
    shape: FloatArray
    weight: FloatArray


class OuterSurface:
    """Quadrature points of the outer faces of a solid.

    Parameters
    ----------
    nodes
        (n, 3) mm.
    faces
        (n_faces, 9) node numbers of the outer faces.
    cell_of_face
        (n_faces,) cell whose face zeta = +1 each one is.
    points_per_side
        Gauss points along each side of a face.
    """

    def __init__(self, nodes: FloatArray, faces: IntArray, cell_of_face: IntArray, points_per_side: int = 4) -> None:
        points, self._quadrature = gauss_points((points_per_side, points_per_side))
        shape, self._slope = shape_quadrilateral(points)
        faces = np.ascontiguousarray(faces, dtype=np.int64)
        self.faces = ContactFaces(faces, cell_of_face, shape, self._areas(nodes[faces]))
        self.points = self.interpolate(nodes)

    def _areas(self, corners: FloatArray) -> FloatArray:
        tangents = np.einsum("fai,qaj->fqji", corners, self._slope)
        area: FloatArray = np.linalg.norm(np.cross(tangents[..., 0, :], tangents[..., 1, :]), axis=-1)
        return np.ascontiguousarray(area * self._quadrature)

    @property
    def area(self) -> float:
        """Undeformed area, mm²."""
        return float(self.faces.weight.sum())

    def interpolate(self, field: FloatArray) -> FloatArray:
        """Nodal field (n, 3) at the quadrature points: (n_points, 3)."""
        values: FloatArray = np.einsum("qa,fai->fqi", self.faces.shape, field[self.faces.nodes])
        return values.reshape(-1, 3)

    def current_area(self, nodes: FloatArray, touching: BoolArray) -> float:
        """Deformed area in mm² of the points marked in `touching` (n_points,), nodes (n, 3) deformed."""
        return float(self._areas(nodes[self.faces.nodes]).ravel()[touching].sum())

    def correct(
        self, law: ContactLaw, touch: Touch, before: tuple[FloatArray, Plane], after: tuple[FloatArray, Plane]
    ) -> Touch:
        """Correct sticking places and limits by a solution in which points that touch anew slid freely.

        `before` is the last equilibrium, `after` the solution: points (n_points, 3) mm and wall of each. A point
        that came to touch sticks where it crossed the wall; one that left sticks no more. Up to its crossing, at
        the share a of the increment, a point ahead of a front that sweeps on evenly and sticks slides half as far
        as one ahead of a front that stays: with the strain rate e of the free part and the front at L t, it moves
        ``∫ e (x - L t) dt = e x a / 2`` up to ``a = x / L``, where the free solution gives ``e x a``.
        """
        reach0, place0 = _in_plane(*before)
        reach1, place1 = _in_plane(*after)
        fresh = (touch.limit == 0) & (reach1 > 0)
        share = np.clip(np.divide(-reach0, reach1 - reach0, out=np.zeros_like(reach0), where=fresh), 0.0, 1.0)
        swept = 0.5 * share if (touch.limit > 0).any() else share
        crossing = place0 + swept[:, None] * (place1 - place0)
        return Touch(np.where(fresh[:, None], crossing, touch.place), _friction_limit(law, reach1), touch.hold)

    def settle(self, law: ContactLaw, touch: Touch, x: FloatArray, plane: Plane) -> Touch:
        """What the points keep of the equilibrium x (n_points, 3) mm: where they stick, after any slip."""
        reach, place = _in_plane(x, plane)
        spring = np.where(touch.limit[:, None] > 0, place - touch.place, 0.0)
        length = law.tangential_stiffness * np.linalg.norm(spring, axis=1)
        kept = np.divide(touch.limit, length, out=np.ones_like(length), where=length > touch.limit)
        return Touch(place - kept[:, None] * spring, _friction_limit(law, reach), touch.hold)

    def dissipate(self, law: ContactLaw, touch: Touch, x: FloatArray, plane: Plane) -> float:
        """Work in mJ of friction in the increment that ends at x (n_points, 3) mm: traction times slip."""
        if not 0 < law.friction < np.inf:
            return 0.0
        _, place = _in_plane(x, plane)
        length = np.linalg.norm(place - touch.place, axis=1)
        slip = np.maximum(length - touch.limit / law.tangential_stiffness, 0.0)
        return float((self.faces.weight.ravel() * touch.limit * slip).sum())

    def states(self, law: ContactLaw, touch: Touch, x: FloatArray, plane: Plane) -> IntArray:
        """State of every point at x (n_points, 3) mm: `FREE`, `STICK` or `SLIP` (frictionless contact slips)."""
        reach, place = _in_plane(x, plane)
        trial = law.tangential_stiffness * np.linalg.norm(place - touch.place, axis=1)
        return np.where(reach <= 0, FREE, np.where(trial < touch.limit, STICK, SLIP)).astype(np.int64)


def untouched(points: int) -> Touch:
    """Nothing has touched yet."""
    return Touch(np.zeros((points, 3)), np.zeros(points), np.zeros(points))


def _in_plane(x: FloatArray, plane: Plane) -> tuple[FloatArray, FloatArray]:
    """Penetration (n,) and place in the plane (n, 3) of points x (n, 3), mm."""
    reach = (x - plane.point) @ plane.normal
    return reach, x - plane.point - reach[:, None] * plane.normal


def _friction_limit(law: ContactLaw, reach: FloatArray) -> FloatArray:
    """Greatest tangential traction (n,) MPa at penetrations (n,) mm; infinite for no slip, zero off the wall."""
    if np.isinf(law.friction):
        return np.where(reach > 0, np.inf, 0.0)
    return law.friction * penalty_pressure(law, reach)


def penalty_pressure(law: ContactLaw, reach: FloatArray) -> FloatArray:
    """Contact pressure in MPa at penetrations (n,) mm."""
    inside = np.maximum(reach, 0.0)
    return np.where(
        inside < law.width,
        law.stiffness * inside**2 / (2 * law.width),
        law.stiffness * (inside - law.width / 2),
    )


@kernel
def assemble_contact(
    faces: ContactFaces,
    place: IntArray,
    position: FloatArray,
    obstacle: tuple[Plane, ContactLaw, Touch],
    system: System,
) -> tuple[float, FloatArray]:
    """Add contact to tangent and residual.

    Parameters
    ----------
    faces, place
        Of the `OuterSurface` and of `palpate.fea.element.Cells`.
    position
        (n, 3) mm deformed nodes.
    obstacle
        The wall, its contact law, and what the points remember of it.
    system
        Added to.

    Returns
    -------
    energy, force
        Contact energy, mJ, and force (3,) N on the wall.
    """
    plane, law, touch = obstacle
    normal = plane.normal
    force, energy = np.zeros(3), 0.0
    x, s, t = np.empty(3), np.empty(3), np.empty(3)
    H = np.empty((3, 3))
    for f in range(len(faces.nodes)):
        nodes = faces.nodes[f]
        for q in range(len(faces.shape)):
            at = f * len(faces.shape) + q
            x[:] = 0.0
            for a in range(9):
                for i in range(3):
                    x[i] += faces.shape[q, a] * position[nodes[a], i]
            delta = 0.0
            for i in range(3):
                x[i] -= plane.point[i]
                delta += normal[i] * x[i]
            if delta <= 0.0 and touch.limit[at] == 0.0 and touch.hold[at] == 0.0:
                continue
            w = faces.weight[f, q]
            density, p, stiffness = _normal_contact(delta, law, touch.hold[at])
            for i in range(3):
                for j in range(3):
                    H[i, j] = stiffness * normal[i] * normal[j]
                t[i] = p * normal[i]
            if touch.limit[at] > 0.0:
                for i in range(3):
                    s[i] = x[i] - delta * normal[i] - touch.place[at, i]
                density += _add_friction(s, normal, touch.limit[at], law.tangential_stiffness, t, H)
            energy += w * density
            for i in range(3):
                force[i] += w * t[i]
            _add_point(nodes, w, faces.shape[q], (t, H), place[faces.cell[f]], system)
    return energy, force


@kernel
def _normal_contact(delta: float, law: ContactLaw, hold: float) -> tuple[float, float, float]:
    """Energy (mJ/mm²), pressure (MPa) and stiffness (MPa/mm) at a penetration in mm."""
    if delta < 0.0:
        return 0.5 * hold * delta * delta, hold * delta, hold
    eps, width = law.stiffness, law.width
    if delta < width:
        return eps * delta**3 / (6.0 * width), eps * delta * delta / (2.0 * width), eps * delta / width
    energy = eps * (0.5 * delta * delta - 0.5 * width * delta + width * width / 6.0)
    return energy, eps * (delta - 0.5 * width), eps


@kernel
def _add_friction(s: FloatArray, normal: FloatArray, limit: float, k: float, t: FloatArray, H: FloatArray) -> float:
    """Add traction and stiffness of the spring s (3,) mm from the sticking place; return its energy, mJ/mm²."""
    length = np.sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2])
    if k * length <= limit:
        for i in range(3):
            t[i] += k * s[i]
            for j in range(3):
                H[i, j] += k * ((1.0 if i == j else 0.0) - normal[i] * normal[j])
        return 0.5 * k * length * length
    for i in range(3):
        si = s[i] / length
        t[i] += limit * si
        for j in range(3):
            H[i, j] += limit / length * ((1.0 if i == j else 0.0) - normal[i] * normal[j] - si * s[j] / length)
    return limit * (length - 0.5 * limit / k)


@kernel
def _add_point(
    nodes: IntArray,
    w: float,
    shape: FloatArray,
    traction: tuple[FloatArray, FloatArray],
    place: IntArray,
    system: System,
) -> None:
    """Add the traction t (3,) and its stiffness H (3, 3) of one point to the system."""
    t, H = traction
    for a in range(9):
        wa = w * shape[a]
        for i in range(3):
            system.residual[3 * nodes[a] + i] += wa * t[i]
            row = 3 * (OUTER_FIRST + a) + i
            start = row * DOFS - row * (row - 1) // 2 - row
            for b in range(a, 9):
                for j in range(i if a == b else 0, 3):
                    target = place[start + 3 * (OUTER_FIRST + b) + j]
                    if target >= 0:
                        system.data[target] += wa * shape[b] * H[i, j]
