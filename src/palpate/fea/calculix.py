"""CalculiX as a second solver: write the deck, run ``ccx``, and read a `Press` of the same layout.

The elements are 20-node bricks with 2 × 2 × 2 points (C3D20R); contact is node to surface, by a penalty. Quantities
that CalculiX does not report are nan: contact energy and stabilisation tension. Stored energy is computed from the
displacement at the 2 × 2 × 2 points (the printed energy ELSE differs strongly from the work of the wall on coarse
meshes). Work is the integral of the force along the wall's path, by monotone cubics. Contact area and apex gap are
measured on the displaced surface, as for palpate's solver.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import tempfile
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any, final

import numpy as np
from scipy.interpolate import PchipInterpolator

from palpate.core import FloatArray, PalpateError, Recipe, Spec, parameter
from palpate.design import Design
from palpate.fea.branch import Branch
from palpate.fea.deck_spec import DeckSpec, Dialect
from palpate.fea.monitor import INVERTED_GAP
from palpate.fea.press import Press
from palpate.fea.press_recipe import press_recipe
from palpate.fea.press_solver import PressSolver
from palpate.fea.read_deck_results import CalculixIncrements, read_counts, read_increments
from palpate.fea.spec import ObstacleSpec
from palpate.fea.wall import WallSpec
from palpate.fea.write_deck import deck_depths, deck_text
from palpate.material import Material
from palpate.mechanics import EndReason, OuterSurface, SolverSpec, fill_nodes
from palpate.mesh import Mesh, MeshSpec, gauss_points, mesh_skin, shape_hexahedron

PROGRAM = "ccx"


class CalculixSpec(Spec):
    """Settings of a CalculiX run; penalty and increment are those of `DeckSpec`."""

    deck: DeckSpec = DeckSpec(dialect=Dialect.CALCULIX)
    timeout: float = parameter(7200.0, unit="s", meaning="longest time a run may take", gt=0)


def find_ccx() -> str:
    """Return the path of the program.

    Raises
    ------
    PalpateError
        If it is not installed.
    """
    path = shutil.which(PROGRAM)
    if path is None:
        raise PalpateError(
            f"CalculiX (the program {PROGRAM}) is not installed or not on the PATH.",
            "Install it with: apt install calculix-ccx",
            code="solver-missing",
        )
    return path


def solve_press_calculix(
    mesh: Mesh, material: Material, obstacle: ObstacleSpec | None = None, spec: CalculixSpec | None = None
) -> Press:
    """Solve one press by CalculiX; mesh, material and obstacle as in `palpate.fea.solve_press`.

    The bricks are those of the mesh without its face and centre nodes, which are interpolated. In the result,
    `contact_energy`, `dissipation` and `stabilisation_tension` are nan, and `negative_pivots` is -1; `jump_depth` is
    the first increment whose apex has left the wall; `solved_by` is ``calculix``.

    Raises
    ------
    PalpateError
        If ``ccx`` is missing, takes too long, or leaves no increment; the last two name the folder with its log.
    """
    obstacle, spec = obstacle or WallSpec(), spec or CalculixSpec()
    program = find_ccx()
    text = deck_text(mesh, material, obstacle, spec.deck)
    folder = Path(tempfile.mkdtemp(prefix="palpate-ccx-"))
    (folder / "press.inp").write_text(text)
    cpu_s, code = _run(program, folder, spec.timeout)
    found = read_increments(folder / "press.dat", len(mesh.nodes))
    if len(found.depth) == 0:
        raise PalpateError(
            f"CalculiX left no increment (exit code {code}): {_last_error(folder / 'press.log')}",
            f"Its deck and log are in {folder}.",
            code="solver-no-increment",
        )
    unknowns, iterations = read_counts(folder / "press.log", folder / "press.cvg")
    ended, message = _reason(found, mesh, obstacle, folder)
    if ended is not EndReason.NOT_CONVERGED:
        shutil.rmtree(folder)
    fields = _fields(found, mesh, material, obstacle)
    inverted = fields["branch"] == str(Branch.INVERTED)
    return Press(
        mesh=mesh,
        material=material,
        obstacle=obstacle,
        solver=SolverSpec(),
        solved_by="calculix",
        **fields,
        ended=ended,
        ended_depth=float(fields["depth"][-1]),
        jump_depth=float(fields["depth"][np.argmax(inverted)]) if inverted.any() else float("nan"),
        cpu_s=cpu_s,
        unknowns=unknowns,
        newton_iterations=iterations,
        message=message,
    )


def calculix_recipe(
    design: Design, mesh: MeshSpec, obstacle: ObstacleSpec, spec: CalculixSpec | None = None
) -> Recipe:
    """Return the recipe of a press by CalculiX: its deck without comments, and the version of the program."""
    spec = spec or CalculixSpec()
    text = deck_text(mesh_skin(design.skin, mesh), design.material, obstacle, spec.deck)
    lines = [line for line in text.splitlines() if not line.startswith("**")]
    solver = {
        "calculix": spec.model_dump(mode="json"),
        "deck": hashlib.sha256("\n".join(lines).encode()).hexdigest(),
        "program": _program_version(),
    }
    return press_recipe(design.skin_spec, mesh, design.material, obstacle, solver)


@cache
def _program_version() -> str:
    """Return the version that ``ccx`` reports; empty if it is not installed."""
    path = shutil.which(PROGRAM)
    if path is None:
        return ""
    said = subprocess.run([path, "-v"], capture_output=True, text=True, timeout=60).stdout
    return said.strip().removeprefix("This is Version ")


@final
@dataclass(frozen=True)
class CalculixSolver(PressSolver):
    """CalculiX as a press solver, with the settings `spec`."""

    spec: CalculixSpec = field(default_factory=CalculixSpec)

    def check(self, obstacle: ObstacleSpec) -> None:
        if obstacle.unload:
            raise PalpateError(
                "CalculiX solves only presses from rest to full depth.",
                "Leave out --unload, or --solver.",
                code="option-not-for-solver",
            )
        find_ccx()

    def solve(self, mesh: Mesh, material: Material, obstacle: ObstacleSpec) -> Press:
        return solve_press_calculix(mesh, material, obstacle, self.spec)


def _run(program: str, folder: Path, timeout: float) -> tuple[float, int]:
    """Run ``ccx`` on ``press.inp`` in its folder with one thread; return CPU-seconds and exit code."""
    threads = dict.fromkeys(("OMP_NUM_THREADS", "CCX_NPROC_STIFFNESS", "CCX_NPROC_EQUATION_SOLVER"), "1")
    before = os.times()
    with (folder / "press.log").open("wb") as log:
        try:
            done = subprocess.run(
                [program, "press"],
                cwd=folder,
                env={**os.environ, **threads},
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                timeout=timeout,
                check=False,
            )
        except subprocess.TimeoutExpired:
            raise PalpateError(
                f"CalculiX took longer than {timeout:g} s and was stopped.",
                f"Use a coarser mesh or a smaller depth; its deck and log are in {folder}.",
                code="solver-timed-out",
            ) from None
    after = os.times()
    spent = after.children_user + after.children_system - before.children_user - before.children_system
    return spent, done.returncode


def _last_error(log: Path) -> str:
    lines = [line.strip() for line in log.read_text(errors="replace").splitlines()]
    errors = [line for line in lines if line.startswith("*ERROR")]
    return errors[-1].removeprefix("*ERROR").strip() if errors else "it gives no reason"


def _reason(found: CalculixIncrements, mesh: Mesh, wall: ObstacleSpec, folder: Path) -> tuple[EndReason, str]:
    goals = deck_depths(mesh, wall)
    last = float(found.depth[-1])
    if last < goals[-1] - 1e-4 * goals[-1]:
        why = _last_error(folder / "press.log")
        return (
            EndReason.NOT_CONVERGED,
            f"CalculiX stopped after {last:.4g} mm: {why} Its deck and log are in {folder}.",
        )
    if goals[-1] < wall.depth:
        return (
            EndReason.WALL_AT_CLAMP,
            f"The wall reached the clamped rim at {goals[-1]:.3f} mm of {wall.depth:g} mm.",
        )
    return EndReason.DEPTH_REACHED, ""


def _fields(found: CalculixIncrements, mesh: Mesh, material: Material, wall: ObstacleSpec) -> dict[str, Any]:
    """Return the arrays of the `Press`: rest, then every increment."""
    half = not mesh.spec.whole
    parts = 2.0 if half else 1.0
    side = np.array([0.0, 1.0, 1.0]) if half else np.ones(3)
    depth = np.concatenate([[0.0], found.depth])
    moved = fill_nodes(mesh.cells, found.displacement)
    displacement = np.concatenate([np.zeros((1, *mesh.nodes.shape)), moved])
    force = np.concatenate([np.zeros((1, 3)), parts * side * found.wall_force])
    gap, area = _contact(mesh, wall, depth, displacement)
    nothing = np.full(len(depth), np.nan)
    return {
        "depth": depth,
        "displacement": displacement,
        "force": force @ wall.turn(mesh).T,
        "energy": parts * np.array([stored_energy(mesh, material, u) for u in displacement]),
        "contact_energy": nothing,
        "dissipation": nothing,
        "work": PchipInterpolator(depth, force @ wall.approach_axis(mesh)).antiderivative()(depth),
        "branch": np.where(gap > INVERTED_GAP * mesh.skin.thickness, str(Branch.INVERTED), str(Branch.FLAT)),
        "peak_stress": np.concatenate([[0.0], found.peak_stress]),
        "contact_area": parts * area,
        "apex_gap": gap,
        "stabilisation_tension": nothing,
        "negative_pivots": np.full(len(depth), -1),
    }


def _contact(
    mesh: Mesh, wall: ObstacleSpec, depth: FloatArray, displacement: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the gap (n,) mm of the first-contact point and the contact area (n,) mm² of the model."""
    first = len(mesh.cells) - len(mesh.outer_faces)
    surface = OuterSurface(mesh.nodes, mesh.outer_faces, np.arange(first, len(mesh.cells)))
    path, touched = wall.path(mesh), wall.at_first_contact(mesh)[1]
    probe = np.argmin(np.linalg.norm(surface.points - touched, axis=1))
    gap, area = [], []
    for d, u in zip(depth, displacement, strict=True):
        points = surface.interpolate(mesh.nodes + u)
        reach = path(d).penetration(points)
        gap.append(-path(d).depth_below(points[probe : probe + 1])[0])
        area.append(surface.current_area(mesh.nodes + u, reach > 0))
    return np.array(gap), np.array(area)


def stored_energy(mesh: Mesh, material: Material, displacement: FloatArray) -> float:
    """Return the energy in mJ of 20-node bricks at their 2 × 2 × 2 points, at a displacement (n, 3) mm."""
    points, weights = gauss_points((2, 2, 2))
    _, local = shape_hexahedron(points)
    rest = fill_nodes(mesh.cells, mesh.nodes)[mesh.cells]
    jacobian = np.einsum("eai,gaj->egij", rest, local)
    slope = np.einsum("gaj,egji->egai", local, np.linalg.inv(jacobian))
    F = np.eye(3) + np.einsum("eai,egaj->egij", displacement[mesh.cells], slope)
    volume = np.linalg.det(jacobian) * weights
    parts = [(slice(mesh.filling, None), material)]
    if material.gel is not None:
        parts.append((slice(mesh.filling), material.gel))
    stored = 0.0
    for cells, own in parts:
        isochoric, _, _ = own.evaluate(F[cells].reshape(-1, 3, 3))
        volumetric = 0.5 * own.bulk_modulus * (np.linalg.det(F[cells]) - 1) ** 2
        stored += float(((isochoric.reshape(volumetric.shape) + volumetric) * volume[cells]).sum())
    return stored
