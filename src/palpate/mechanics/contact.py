"""Contact of a surface with a rigid obstacle, integrated on its quadrature points.

With the penetration ``delta`` of a point, the normal ``n`` of the obstacle there, and its place on the obstacle
``s = (I - n n^T)(x - x_o)``, the contact energy per undeformed area is

    phi(delta) + psi(s - s0),    p = phi'(delta)

* ``phi`` is a penalty of stiffness ``eps`` with a quadratic onset of the force over the width ``w``:
  ``p = eps delta² / 2w`` up to ``delta = w`` and ``eps (delta - w/2)`` beyond, so that the tangent is continuous;
  with the Hessian ``H`` of the penetration its tangent is ``phi'' n n^T + p H``;
* ``psi`` is a spring ``eps_t`` from the place ``s0`` on the obstacle at which the point touched it, limited to the
  traction ``mu p`` (a Huber potential; no slip is mu = infinity, frictionless mu = 0), in the tangent plane of the
  obstacle at ``s0``.

The sticking points, their places and the limits ``mu p`` are the contact history (`palpate.mechanics.friction`). It
is fixed during a solve and corrected between solves, so every solve minimises a smooth energy and its tangent is
symmetric (Wriggers, *Computational Contact Mechanics*, 2006, chapter 5). A point in new contact slides in the first
solve and then sticks where its path crossed the surface.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, final

import numpy as np

from palpate.core import FloatArray, IntArray, kernel
from palpate.mechanics.element import DOFS, System
from palpate.mechanics.friction import ContactHistory, ContactLaw, ContactPair
from palpate.mechanics.obstacle import Obstacle
from palpate.mechanics.solid import State
from palpate.mechanics.surface import ContactFaces, OuterSurface
from palpate.mechanics.term import Assembly, Term, TermContribution

OUTER_FIRST = 18
"""First node of the outer face in a cell."""


class _Points(NamedTuple):
    """Contact points in the kernel.

    `arm` (n, 3) mm from the obstacle's point, `reach`, `normal`, `curvature` of the gap, and the height (n,) mm and
    normal (n, 3) by which `arm` is projected onto the plane of the sticking springs.
    """

    arm: FloatArray
    reach: FloatArray
    normal: FloatArray
    curvature: FloatArray
    height: FloatArray
    axis: FloatArray


@final
@dataclass(frozen=True)
class Contact(Term):
    """Contact of a surface with an obstacle: penalty and friction by `law`, and history of the points."""

    surface: OuterSurface
    law: ContactLaw
    obstacle: Obstacle
    history: ContactHistory

    def assemble(self, state: State, to: Assembly) -> TermContribution:
        return self._assemble(state, to, tangent=True)

    def add_residual(self, state: State, to: Assembly) -> TermContribution:
        """Add the residual alone."""
        return self._assemble(state, to, tangent=False)

    def _assemble(self, state: State, to: Assembly, *, tangent: bool) -> TermContribution:
        points = self._points(self.surface.place(to.nodes + state.u))
        rules = (self.law, self.history)
        return TermContribution(*_assemble_points(self.surface.faces, to.place, points, rules, to.system, tangent))

    def energy(self, state: State, nodes: FloatArray) -> float:
        """Return the energy in mJ of a state of the body with these nodes (n, 3) mm."""
        points = self._points(self.surface.place(nodes + state.u))
        return float(_sum_energy(self.surface.faces, points, (self.law, self.history)))

    def meet(self, state: State, nodes: FloatArray) -> ContactPair:
        """Return the contact points of a state of the body with these nodes (n, 3) mm, and the obstacle."""
        return ContactPair(self.surface.interpolate(nodes + state.u), self.obstacle)

    def _points(self, x: FloatArray) -> _Points:
        gap, arm = self.obstacle.gap(x), x - self.obstacle.point
        if gap.curvature is None:
            return _Points(arm, gap.penetration, gap.normal, np.zeros((len(x), 3, 3)), gap.penetration, gap.normal)
        height = np.einsum("ni,ni->n", arm - self.history.anchor, self.history.normal)
        return _Points(arm, gap.penetration, gap.normal, gap.curvature, height, self.history.normal)


@kernel
def _assemble_points(
    faces: ContactFaces,
    place: IntArray,
    points: _Points,
    contact: tuple[ContactLaw, ContactHistory],
    system: System,
    tangent: bool,
) -> tuple[float, FloatArray]:
    """Add contact to residual and `tangent`; return its energy, mJ, and the force (3,) N on the obstacle.

    `place` is that of `palpate.mechanics.element.Cells`.
    """
    law, history = contact
    force, energy = np.zeros(3), 0.0
    x, s, t = np.empty(3), np.empty(3), np.empty(3)
    H = np.empty((3, 3))
    for f in range(len(faces.nodes)):
        nodes = faces.nodes[f]
        for q in range(len(faces.shape)):
            at = f * len(faces.shape) + q
            delta = points.reach[at]
            for i in range(3):
                x[i] = points.arm[at, i]
            if delta <= 0.0 and history.limit[at] == 0.0 and history.stabilisation[at] == 0.0:
                continue
            w = faces.weight[f, q]
            density, p, stiffness = _normal_contact(delta, law, history.stabilisation[at])
            normal = points.normal[at]
            for i in range(3):
                for j in range(3):
                    H[i, j] = stiffness * normal[i] * normal[j] + p * points.curvature[at, i, j]
                t[i] = p * normal[i]
            if history.limit[at] > 0.0:
                axis = points.axis[at]
                for i in range(3):
                    s[i] = x[i] - points.height[at] * axis[i] - history.anchor[at, i]
                density += _add_friction(s, axis, history.limit[at], law.tangential_stiffness, t, H)
            energy += w * density
            for i in range(3):
                force[i] += w * t[i]
            for a in range(9):
                for i in range(3):
                    system.residual[3 * nodes[a] + i] += w * faces.shape[q, a] * t[i]
            if tangent:
                _add_stiffness(w, faces.shape[q], H, place[faces.cell[f]], system)
    return energy, force


@kernel
def _sum_energy(faces: ContactFaces, points: _Points, contact: tuple[ContactLaw, ContactHistory]) -> float:
    """Return the energy of contact, mJ, as `_assemble_points`."""
    law, history = contact
    energy = 0.0
    s, t, H = np.empty(3), np.zeros(3), np.zeros((3, 3))
    for f in range(len(faces.nodes)):
        for q in range(len(faces.shape)):
            at = f * len(faces.shape) + q
            density = _normal_contact(points.reach[at], law, history.stabilisation[at])[0]
            if history.limit[at] > 0.0:
                axis = points.axis[at]
                for i in range(3):
                    s[i] = points.arm[at, i] - points.height[at] * axis[i] - history.anchor[at, i]
                density += _add_friction(s, axis, history.limit[at], law.tangential_stiffness, t, H)
            energy += faces.weight[f, q] * density
    return energy


@kernel
def _normal_contact(delta: float, law: ContactLaw, pull: float) -> tuple[float, float, float]:
    """Return energy (mJ/mm²), pressure (MPa) and stiffness (MPa/mm) at a penetration in mm."""
    if delta < 0.0:
        return 0.5 * pull * delta * delta, pull * delta, pull
    eps, width = law.stiffness, law.width
    if delta < width:
        return eps * delta**3 / (6.0 * width), eps * delta * delta / (2.0 * width), eps * delta / width
    energy = eps * (0.5 * delta * delta - 0.5 * width * delta + width * width / 6.0)
    return energy, eps * (delta - 0.5 * width), eps


@kernel
def _add_friction(s: FloatArray, normal: FloatArray, limit: float, k: float, t: FloatArray, H: FloatArray) -> float:
    """Add traction and stiffness of the sticking spring s (3,) mm; return its energy, mJ/mm²."""
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
def _add_stiffness(w: float, shape: FloatArray, H: FloatArray, place: IntArray, system: System) -> None:
    """Add the stiffness H (3, 3) of one point to the tangent."""
    for a in range(9):
        wa = w * shape[a]
        for i in range(3):
            row = 3 * (OUTER_FIRST + a) + i
            start = row * DOFS - row * (row - 1) // 2 - row
            for b in range(a, 9):
                for j in range(i if a == b else 0, 3):
                    target = place[start + 3 * (OUTER_FIRST + b) + j]
                    if target >= 0:
                        system.data[target] += wa * shape[b] * H[i, j]
