"""`palpate press`: one dome under one wall, image by image."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from cyclopts import Parameter
from numpy.typing import NDArray

from palpate.cli.flag import JsonFlag, default, flag
from palpate.cli.output import print_json, print_table
from palpate.core import PalpateError
from palpate.design import Dome, DomeSpec, build_dome, read_points
from palpate.fea import Press, WallSpec, read_contact, solve_press
from palpate.mesh import MeshSpec, Rim, mesh_dome
from palpate.study import MaterialSpec

_POINTS = "CSV of undeformed points of the inner surface (x_mm, y_mm, z_mm), followed through every image."


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
    points: Annotated[Path | None, Parameter(help=_POINTS)] = None


def press(*, flags: PressFlags | None = None, json: JsonFlag = False) -> None:
    """Press one dome by a flat wall and follow it image by image."""
    flags = flags or PressFlags()
    dome = build_dome(DomeSpec(height=flags.height, base_radius=flags.base_radius, thickness=flags.thickness))
    points = None if flags.points is None else _read_inner_points(flags.points, dome)
    material = MaterialSpec(name=flags.material, bulk_ratio=flags.bulk_ratio).material()
    wall = WallSpec(
        tilt_deg=flags.tilt,
        azimuth_deg=flags.azimuth,
        depth=flags.depth,
        image_step=flags.step,
        contact=read_contact(flags.contact),
    )
    mesh = mesh_dome(dome, MeshSpec(cells=flags.cells, rim=flags.rim, whole=flags.whole))
    solved = solve_press(mesh, material, wall)
    if json:
        print_json(describe_press(solved, points))
    else:
        _print_press(solved)


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
            f"Points lie up to {dome.widest_radius:.4g} mm from the axis.",
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
