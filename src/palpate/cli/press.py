"""`palpate press`: one dome under one wall, image by image."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from cyclopts import Parameter
from numpy.typing import NDArray

from palpate.cli.compiling import announce_compilation
from palpate.cli.flag import JsonFlag, default, flag
from palpate.cli.output import print_json, print_table
from palpate.core import PalpateError
from palpate.deck import solve_press_calculix
from palpate.design import Dome, DomeSpec, Rim, build_dome, read_points
from palpate.fea import Branch, Press, WallSpec, check_export, export_press, read_contact, solve_press
from palpate.material import Material
from palpate.mesh import Mesh, MeshSpec, mesh_dome
from palpate.study import MaterialSpec

_POINTS = "CSV of undeformed points of the inner surface (x_mm, y_mm, z_mm), followed through every image."
_SOLVER = "Who solves: palpate itself, or CalculiX (apt install calculix-ccx)."
_BRANCH = "The state that is pressed from rest, or the one with its apex turned inside out, where it exists."
_EXPORT = "New folder for the images as .vtu files with a .pvd series, and force.csv."


class Solver(StrEnum):
    """Who solves a press."""

    PALPATE = "palpate"
    CALCULIX = "calculix"


@Parameter(name="*")
@dataclass(frozen=True)
class PressFlags:
    """What `palpate press` may be told."""

    height: Annotated[float, flag(DomeSpec, "height")] = default(DomeSpec, "height")
    thickness: Annotated[float, flag(DomeSpec, "thickness")] = default(DomeSpec, "thickness")
    base_radius: Annotated[float, flag(DomeSpec, "base_radius")] = default(DomeSpec, "base_radius")
    tilt: Annotated[float, flag(WallSpec, "tilt_deg")] = default(WallSpec, "tilt_deg")
    azimuth: Annotated[float, flag(WallSpec, "azimuth_deg")] = default(WallSpec, "azimuth_deg")
    depth: Annotated[float, flag(WallSpec, "depth")] = default(WallSpec, "depth")
    step: Annotated[float, flag(WallSpec, "image_step")] = default(WallSpec, "image_step")
    contact: Annotated[str, flag(WallSpec, "contact")] = default(WallSpec, "contact")
    material: Annotated[str, flag(MaterialSpec, "name")] = default(MaterialSpec, "name")
    bulk_ratio: Annotated[float | None, flag(MaterialSpec, "bulk_ratio")] = None
    rim: Annotated[Rim, Parameter(help="Base cut flat at z = 0, or radially from the sphere's centre.")] = Rim.FLAT
    whole: Annotated[bool, Parameter(negative="", help="Solve the whole dome, not its half.")] = False
    cells: Annotated[int | None, flag(MeshSpec, "cells")] = None
    unload: Annotated[bool, Parameter(negative="", help="Draw the wall back to first touch as well.")] = False

    def dome(self) -> Dome:
        """The dome of these flags."""
        return build_dome(DomeSpec(height=self.height, base_radius=self.base_radius, thickness=self.thickness))

    def problem(self) -> tuple[Mesh, Material, WallSpec]:
        """What is pressed: mesh, material and wall of these flags."""
        material = MaterialSpec(name=self.material, bulk_ratio=self.bulk_ratio).material()
        wall = WallSpec(
            tilt_deg=self.tilt,
            azimuth_deg=self.azimuth,
            depth=self.depth,
            image_step=self.step,
            contact=read_contact(self.contact),
            unload=self.unload,
        )
        return mesh_dome(self.dome(), MeshSpec(cells=self.cells, rim=self.rim, whole=self.whole)), material, wall


def press(
    *,
    flags: PressFlags | None = None,
    points: Annotated[Path | None, Parameter(help=_POINTS)] = None,
    solver: Annotated[Solver, Parameter(help=_SOLVER)] = Solver.PALPATE,
    export: Annotated[Path | None, Parameter(help=_EXPORT)] = None,
    branch: Annotated[Branch, Parameter(help=_BRANCH)] = Branch.FLAT,
    json: JsonFlag = False,
) -> None:
    """Press one dome by a flat wall and follow it image by image."""
    flags = flags or PressFlags()
    followed = None if points is None else _read_inner_points(points, flags.dome())
    problem = flags.problem()
    if export is not None:
        check_export(export)
    solved = _solve(problem, solver, branch)
    if export is not None:
        export_press(export, solved)
    if json:
        print_json(describe_press(solved, followed))
    else:
        _print_press(solved)


def _solve(problem: tuple[Mesh, Material, WallSpec], solver: Solver, branch: Branch) -> Press:
    if solver is Solver.PALPATE:
        announce_compilation()
        return solve_press(*problem, branch=branch)
    if branch is Branch.INVERTED or problem[2].unload:
        raise PalpateError(
            "CalculiX presses the flat branch from rest to full depth.",
            "Leave out --branch and --unload, or --solver.",
        )
    return solve_press_calculix(*problem)


def describe_press(press: Press, points: NDArray[np.float64] | None = None) -> dict[str, Any]:
    """A press as JSON data.

    Parameters
    ----------
    press
        The press.
    points
        (m, 3) undeformed points of the inner surface that are followed, mm.
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
        }
        for i in range(len(press.depth))
    ]
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


def _read_inner_points(path: Path, dome: Dome) -> NDArray[np.float64]:
    points = read_points(path, dome)
    outside = np.flatnonzero(~np.isfinite(points[:, 2]))
    if len(outside):
        x, y = points[outside[0], :2]
        raise PalpateError(
            f"{path}: point {outside[0] + 1} ({x:g}, {y:g}) mm is outside the dome.",
            f"Points lie up to {dome.widest[0]:.4g} mm from the axis.",
        )
    return points


def _print_press(press: Press) -> None:
    columns = [
        "depth mm",
        "Fx N",
        "Fy N",
        "Fz N",
        "energy mJ",
        "work mJ",
        "stress MPa",
        "contact mm²",
        "branch",
    ]
    rows = [
        [
            f"{image['depth_mm']:.2f}",
            *(f"{force:.4f}" for force in image["force_n"]),
            f"{image['energy_mj']:.4f}",
            f"{image['work_mj']:.4f}",
            f"{image['peak_stress_mpa']:.4f}",
            f"{image['contact_area_mm2']:.1f}",
            image["branch"],
        ]
        for image in describe_press(press)["images"]
    ]
    print_table("press", columns, rows)
    print(
        f"ended: {press.ended} at {press.ended_depth:.2f} mm; {press.unknowns} unknowns, "
        f"{press.newton_iterations} Newton iterations, {press.cpu_s:.1f} CPU-seconds"
    )
