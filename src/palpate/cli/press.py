"""`palpate press`: one press of a skin by an obstacle, increment by increment."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from cyclopts import Parameter

from palpate.cli.compiling import announce_compilation
from palpate.cli.flag import flags_of
from palpate.cli.output import Output
from palpate.cli.unit import MaterialFlags, SkinFlags
from palpate.core import FloatArray, PalpateError, flag_name
from palpate.core.report import Column, Report
from palpate.design import Skin, read_points
from palpate.fea import PRESS_SOLVERS, Branch, ObstacleSpec, PalpateSolver, PressSolver, WallSpec, read_obstacle
from palpate.material import Material
from palpate.mechanics import SolverSpec
from palpate.mesh import Mesh, MeshSpec, mesh_skin
from palpate.study import MaterialSpec

if TYPE_CHECKING:
    from palpate.fea import Press

_COLUMNS = (
    Column("depth_mm", form=".2f"),
    *(Column(f"force_{axis}_n", f"F{axis}", form=".4f", meaning=f"contact force, {axis}") for axis in "xyz"),
    Column("energy_mj", form=".4f", meaning="strain energy of the skin"),
    Column("work_mj", form=".4f", meaning="work of the obstacle", deciding=False),
    Column("peak_stress_mpa", "peak stress", form=".4f", meaning="maximum von Mises stress"),
    Column("contact_area_mm2", "contact area", "mm²", form=".1f"),
    Column(
        "peak_pressure_mpa",
        "peak pressure",
        form=".4f",
        meaning="maximum contact pressure; it depends on the mesh",
        deciding=False,
    ),
    Column(
        "hold_tension_kpa",
        "stabilisation tension",
        form=".2f",
        meaning="maximum tension by contact stabilisation",
        deciding=False,
    ),
    Column("branch", meaning="family of equilibria: flat or inverted"),
)
_POINTS = "CSV of undeformed points of the inner surface (x_mm, y_mm, z_mm); their positions are in the JSON."
_SOLVER = "Solver: palpate, calculix (apt install calculix-ccx), or the solver of an installed package."
_OBSTACLE = "Obstacle as KIND:NAME=VALUE, such as ball:radius=8; depth, step and contact law as for the wall."
_BRANCH = "Branch of equilibria: flat, or inverted (apex inside out) if it exists."
_EXPORT = "New folder for the increments as .vtu files with a .pvd series, force.csv and contact.csv."


WallFlags = Annotated[WallSpec, flags_of(WallSpec, group="Wall")]
MeshFlags = Annotated[MeshSpec, flags_of(MeshSpec, group="Mesh")]
SolverFlags = Annotated[SolverSpec, flags_of(SolverSpec, group="Advanced")]


@Parameter(name="*")
@dataclass(frozen=True)
class WallPressFlags:
    """Specs of a press by a flat wall; each field is a flag."""

    shape: SkinFlags = SkinFlags()
    wall: WallFlags = WallSpec()
    material: MaterialFlags = MaterialSpec()
    mesh: MeshFlags = MeshSpec()

    def obstacle_spec(self) -> ObstacleSpec:
        """Return the obstacle of these flags."""
        return self.wall

    def problem(self) -> tuple[Mesh, Material, ObstacleSpec]:
        """Return mesh, material and obstacle of these flags."""
        mesh = mesh_skin(self.shape.skin_spec().build(), self.material.mesh(self.mesh))
        return mesh, self.material.material(), self.obstacle_spec()


@Parameter(name="*")
@dataclass(frozen=True)
class PressFlags(WallPressFlags):
    """Specs of a press by any obstacle; each field is a flag."""

    obstacle: Annotated[str, Parameter(help=_OBSTACLE, group="Wall")] = "wall"

    def obstacle_spec(self) -> ObstacleSpec:
        """Return the obstacle of these flags."""
        return read_obstacle(self.obstacle, self.wall)


@Parameter(name="*")
@dataclass(frozen=True)
class RefinedFlags(PressFlags):
    """Specs of a press on several meshes, whose cells are given by another flag."""

    mesh: Annotated[MeshSpec, flags_of(MeshSpec, without="cells", group="Mesh")] = MeshSpec()


@Parameter(name="*")
@dataclass(frozen=True)
class SolveFlags:
    """Solver of a press, its settings, and the branch."""

    solver: Annotated[str, Parameter(help=_SOLVER)] = "palpate"
    branch: Annotated[Branch, Parameter(help=_BRANCH)] = Branch.FLAT
    advanced: SolverFlags = SolverSpec()

    def chosen(self, wall: ObstacleSpec) -> PressSolver:
        """Return the solver of these flags; reject a press it cannot solve, before the computation."""
        from palpate.mechanics import make_linear_solver

        kind = PRESS_SOLVERS.get(self.solver)
        if kind is PalpateSolver:
            make_linear_solver(self.advanced.backend)
            return PalpateSolver(self.advanced, self.branch)
        if self.branch is Branch.INVERTED:
            raise PalpateError(
                f"--branch is {self.branch}, and the solver {self.solver} follows only the flat branch.",
                "Leave out --branch, or --solver.",
                code="option-not-for-solver",
            )
        if self.advanced.model_fields_set:
            chosen = ", ".join(f"--{flag_name(SolverSpec, name)}" for name in sorted(self.advanced.model_fields_set))
            raise PalpateError(
                f"{chosen}: setting of the solver palpate, not of {self.solver}.",
                "Leave out these flags, or --solver.",
                code="option-not-for-solver",
            )
        solver = kind()
        solver.check(wall)
        return solver

    def solve(self, problem: tuple[Mesh, Material, ObstacleSpec]) -> Press:
        """Solve a press."""
        solver = self.chosen(problem[2])
        if isinstance(solver, PalpateSolver):
            announce_compilation()
        return solver.solve(*problem)


def press(
    *,
    flags: PressFlags = PressFlags(),
    how: SolveFlags = SolveFlags(),
    points: Annotated[Path | None, Parameter(help=_POINTS)] = None,
    export: Annotated[Path | None, Parameter(help=_EXPORT)] = None,
    output: Output = Output(),
) -> None:
    """Solve one press of a skin by a flat wall or another obstacle, increment by increment."""
    how.chosen(flags.obstacle_spec())
    followed = None if points is None else _read_inner_points(points, flags.shape.skin_spec().build())
    from palpate.fea import check_export, export_press

    if export is not None:
        check_export(export)
    problem = flags.problem()
    solved = how.solve(problem)
    if export is not None:
        export_press(export, solved)
    facts = describe_press(solved, followed)
    title = f"{flags.shape.skin_spec().build().name}, {problem[1].name}: {problem[2].label}, {problem[2].contact}"
    output.show(facts, _report(title, facts, str(export / "force.csv") if export is not None else ""))


def describe_press(press: Press, points: FloatArray | None = None) -> dict[str, Any]:
    """Return a press as JSON data.

    Parameters
    ----------
    press
        The press.
    points
        (m, 3) undeformed points of the inner surface whose positions are added, mm.
    """
    images: list[dict[str, Any]] = [
        {
            "depth_mm": float(press.depth[i]),
            "force_n": press.force[i].tolist(),
            "energy_mj": float(press.energy[i]),
            "contact_energy_mj": float(press.contact_energy[i]),
            "dissipation_mj": float(press.dissipation[i]),
            "work_mj": float(press.work[i]),
            "branch": str(press.branch[i]),
            "peak_stress_mpa": float(press.peak_stress[i]),
            "contact_area_mm2": float(press.contact_area[i]),
            "apex_gap_mm": float(press.apex_gap[i]),
            "hold_tension_mpa": float(press.stabilisation_tension[i]),
        }
        for i in range(len(press.depth))
    ]
    if press.solved_by == "palpate":
        from palpate.fea import contact_traction

        for image, pressure in zip(images, contact_traction(press).pressure, strict=True):
            image["peak_pressure_mpa"] = float(pressure.max())
    if points is not None:
        for image, moved in zip(images, press.positions(points), strict=True):
            image["points_mm"] = moved.tolist()
    return {
        "ended": str(press.ended),
        "ended_depth_mm": float(press.ended_depth),
        "jump_depth_mm": float(press.jump_depth),
        "message": press.message,
        "cpu_s": float(press.cpu_s),
        "unknowns": int(press.unknowns),
        "newton_iterations": int(press.newton_iterations),
        "images": images,
    }


def _read_inner_points(path: Path, skin: Skin) -> FloatArray:
    points = read_points(path, skin)
    outside = np.flatnonzero(~np.isfinite(points[:, 2]))
    if len(outside):
        x, y = points[outside[0], :2]
        raise PalpateError(
            f"{path}: point {outside[0] + 1} ({x:g}, {y:g}) mm is outside the skin.",
            f"Give points at most {skin.widest[0]:.4g} mm from the axis.",
            code="point-outside-skin",
        )
    return points


def _report(title: str, facts: dict[str, Any], file: str) -> Report:
    rows = [
        image
        | dict(zip(("force_x_n", "force_y_n", "force_z_n"), image["force_n"], strict=True))
        | {"hold_tension_kpa": 1e3 * image["hold_tension_mpa"]}
        for image in facts["images"]
    ]
    note = (
        f"ended: {facts['ended']} at {facts['ended_depth_mm']:.2f} mm; {facts['unknowns']} unknowns, "
        f"{facts['newton_iterations']} Newton iterations, {facts['cpu_s']:.1f} CPU-seconds"
    )
    return Report(title, _COLUMNS, rows, (note,), file)
