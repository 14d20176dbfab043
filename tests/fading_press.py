"""A press of a skin that relaxes, integrated point by point: the way that `palpate.material` does not go.

At every Gauss point the second Piola-Kirchhoff stress of the law's isochoric part has a history of its own, carried
along with the material (Simo 1987, doi 10.1016/0045-7825(87)90107-1), and equilibrium is solved anew at every time;
the volumetric part is elastic, so that K over the modulus grows while the skin relaxes. So shape, contact and force
all are free to change in time.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from palpate.core import FloatArray
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers
from palpate.fea import Press, WallSpec
from palpate.fea.solve_press import start_press
from palpate.material import Law, Relaxation, get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, centre_mesh, mesh_skin
from presses import solve_press

VOIGT = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0))
ONE = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
SYMMETRIC = np.diag([1.0, 1.0, 1.0, 0.5, 0.5, 0.5])


@dataclass(frozen=True)
class FadingLaw(Law):
    """A law whose stress fades at each of the points where it is asked; `keep` ends an increment of time."""

    base: Law
    relaxation: Relaxation
    memory: dict[str, Any] = field(default_factory=dict)
    name = "fading"

    @property
    def shear_modulus(self) -> float:
        return self.base.shear_modulus

    def scaled(self, modulus: float, stiffening: float = 1.0) -> FadingLaw:
        return replace(self, base=self.base.scaled(modulus, stiffening))

    def deck(self) -> None:
        return None

    @classmethod
    def models(cls) -> tuple[()]:
        return ()

    def isochoric(self, F: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        energy, tau, c = self.base.isochoric(F)
        inverse, J = np.linalg.inv(F), np.linalg.det(F)[:, None, None] ** (2 / 3)
        S = J * (inverse @ unfold(tau) @ inverse.transpose(0, 2, 1))
        before = self.memory.get("stress", np.zeros_like(S))
        parts = self.memory.get("parts", [np.zeros_like(S) for _ in self.relaxation.times])
        now, share, kept = [], self.relaxation.long_term_share, np.zeros_like(S)
        for lost, time, part in zip(self.relaxation.shares, self.relaxation.times, parts, strict=True):
            x = self.memory["passed"] / time
            taken = -np.expm1(-x) / x
            old = np.exp(-x) * part - taken * before
            now.append(old + taken * S)
            kept, share = kept + lost * old, share + lost * taken
        self.memory["now"] = S, now
        A = F @ kept @ F.transpose(0, 2, 1) / J
        trace = np.trace(A, axis1=1, axis2=2)[:, None, None]
        B = A - trace / 3 * np.eye(3)
        b = np.stack([B[:, i, j] for i, j in VOIGT], axis=1)
        tangent = -2 / 3 * (ONE[:, None] * b[:, None, :] + b[:, :, None] * ONE)
        tangent = tangent + 2 / 3 * trace * (SYMMETRIC - np.outer(ONE, ONE) / 3)
        scale = self.relaxation.scale
        return scale * share * energy, scale * (share * tau + b), scale * (share * c + tangent)

    def keep(self) -> None:
        """End an increment."""
        self.memory["stress"], self.memory["parts"] = self.memory["now"]


def unfold(stress: FloatArray) -> FloatArray:
    """Tensors (n, 3, 3) of stresses (n, 6)."""
    found = np.empty((len(stress), 3, 3))
    for k, (i, j) in enumerate(VOIGT):
        found[:, i, j] = found[:, j, i] = stress[:, k]
    return found


@dataclass(frozen=True)
class FadingPress:
    """Times (n,) s, depths (n,) mm, force (n, 3) N, markers (n, m, 3) mm, and the elastic press of the same wall."""

    time: FloatArray
    depth: FloatArray
    force: FloatArray
    markers: FloatArray
    elastic: Press


def press_fading(relaxation: Relaxation, wall: WallSpec, ramp: float, holds: tuple[float, ...]) -> FadingPress:
    """Press H20 T2 to the wall's depth in `ramp` s and hold it; `holds` are times in s after that."""
    skin = build_skin(DomeSpec(height=20, thickness=2))
    mesh, markers = mesh_skin(skin, MeshSpec()), place_markers(skin, MarkerSpec(count=91)).positions
    plain = get_material("zaid_2024_ecoflex_00_30")
    elastic = solve_press(mesh, plain, wall)
    law = FadingLaw(plain.law, relaxation)
    mesh = centre_mesh(mesh, wall.at_first_contact(mesh)[1])
    path = start_press(mesh, replace(plain, law=law), wall, SolverSpec())
    depths = elastic.depth[1:]
    plan = [(ramp * depth / wall.depth, float(depth)) for depth in depths] + [(ramp + t, wall.depth) for t in holds]
    before, force, fields = 0.0, [], []
    for time, depth in plan:
        law.memory["passed"], before = time - before, time
        moves = depth > path.last.depth
        start = path._stuck(depth, path._predict(depth)) if moves else path.last.state
        found = path._solve(depth, start)
        assert found.converged, (time, depth, found.outcome)
        path._accept(found, depth, jumped=False)
        path.problem.body.respond(found.state)
        law.keep()
        force.append(2 * found.loads.force * [0, 1, 1])
        fields.append(found.state.u)
    moved = replace(elastic, mesh=mesh, displacement=np.array(fields)).positions(markers)
    return FadingPress(*map(np.array, zip(*plan, strict=True)), np.array(force), moved, elastic)
