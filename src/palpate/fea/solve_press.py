"""Press a dome by a rigid flat wall."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from palpate.core import FloatArray
from palpate.fea.contact import ContactLaw, OuterSurface, Plane, untouched
from palpate.fea.linear import make_linear_solver
from palpate.fea.newton import ContactProblem, Loads
from palpate.fea.path import Path, Point
from palpate.fea.press import Branch, Ended, Press, azimuth_rotation
from palpate.fea.solid import Solid
from palpate.fea.spec import SolverSpec, WallSpec
from palpate.fea.stress import cauchy_stress, von_mises
from palpate.fea.wall import clamp_depth, normal_in_mesh, touch_point, wall_at
from palpate.material import Material
from palpate.mesh import Mesh

_PUSHES = (1.0, 2.0, 3.0)
"""Pushes of the apex over the thickness that are tried to find the inverted state."""


def solve_press(
    mesh: Mesh,
    material: Material,
    wall: WallSpec | None = None,
    solver: SolverSpec | None = None,
    branch: Branch = Branch.FLAT,
    observe: Callable[[float], None] | None = None,
) -> Press:
    """Solve one press from first touch to full depth.

    Parameters
    ----------
    mesh
        Half or whole dome. A half model is solved in the tilt plane and turned to the azimuth of the wall; a whole
        one is solved with the wall where it is.
    material
        The elastomer.
    wall
        Tilt, azimuth, depth, image step and contact law.
    solver
        How to solve.
    branch
        Flat: pressed from rest. Inverted: the other state, found at the greatest depth and followed back to where
        it ends; it has no image at rest, and its work counts from the energy stored there.
    observe
        Called with the depth in mm of each image on the way down as soon as it is solved.

    Returns
    -------
    Press
        Images at rest, at every image step, and at the end where it came early, with its reason.

    Raises
    ------
    PalpateError
        If the wall would touch the clamped rim before the dome.
    """
    wall, solver = wall or WallSpec(), solver or SolverSpec()
    started = time.process_time()
    normal = normal_in_mesh(mesh, wall)
    problem = make_problem(mesh, material, wall.friction, solver)
    path = start_path(problem, mesh, normal, solver)
    reachable = clamp_depth(mesh.dome, np.radians(wall.tilt_deg), mesh.spec.rim)
    goals = image_depths(wall, min(wall.depth, reachable))
    images = _press_down(path, goals, observe)
    if wall.unload and path.ended is Ended.DEPTH_REACHED:
        images += _draw_back(path, goals)
    if branch is Branch.INVERTED:
        images = _follow_back(path, goals, mesh.dome.thickness)
    ended, message = path.ended, path.message
    if ended is Ended.DEPTH_REACHED and reachable < wall.depth:
        ended = Ended.WALL_AT_CLAMP
        message = f"The wall reached the clamped rim at {reachable:.3f} mm of {wall.depth:g} mm."
    fields = _fields(path, images, mesh, wall.azimuth_deg)
    jumps = [point.depth for point in path.points if point.jumped]
    return Press(
        mesh=mesh,
        material=material,
        wall=wall,
        solver=solver,
        **fields,
        ended=ended,
        ended_depth=path.points[-1].depth,
        jump_depth=jumps[0] if jumps else float("nan"),
        cpu_s=time.process_time() - started,
        unknowns=problem.solid.unknowns,
        newton_iterations=path.iterations,
        message=message,
    )


def _press_down(path: Path, goals: list[float], observe: Callable[[float], None] | None) -> list[int]:
    """Press to the depths (mm) of the images as far as they go; the points of the path that are images."""
    images = [0]
    for goal in goals:
        if not path.advance(goal):
            if path.points[-1].depth > path.points[images[-1]].depth:
                images.append(len(path.points) - 1)
            break
        images.append(len(path.points) - 1)
        if observe is not None:
            observe(goal)
    return images


def _draw_back(path: Path, goals: list[float]) -> list[int]:
    """Draw the wall back through the depths (mm) of the images to first touch; the points that are images."""
    images = []
    for goal in [*reversed(goals[:-1]), 0.0]:
        if not path.advance(goal):
            break
        images.append(len(path.points) - 1)
    return images


def _follow_back(path: Path, goals: list[float], thickness: float) -> list[int]:
    """Invert the apex at the depth reached and follow that branch back; its points, and those that are images."""
    rest, deepest = path.points[0], path.points[-1].depth
    if not any(path.invert(push * thickness) for push in _PUSHES):
        path.points = [rest]
        path.ended, path.message = Ended.NO_BRANCH, f"No inverted state was found at {deepest:.4g} mm."
        return [0]
    path.ended, path.message, images = Ended.DEPTH_REACHED, "", [0]
    for goal in reversed([goal for goal in goals if goal < deepest - 1e-6]):
        reached = path.advance(goal)
        if len(path.points) - 1 > images[-1]:
            images.append(len(path.points) - 1)
        if not reached:
            break
    path.points = [replace(point, jumped=False) for point in reversed(path.points)]
    return [len(path.points) - 1 - image for image in reversed(images)]


def image_depths(wall: WallSpec, deepest: float) -> list[float]:
    """Depths in mm of the images after rest: every image step, and the deepest."""
    count = int(np.floor(deepest / wall.image_step + 1e-9))
    depths = [wall.image_step * (k + 1) for k in range(count)]
    if not depths or deepest - depths[-1] > 1e-6:
        depths.append(deepest)
    return depths


def make_problem(mesh: Mesh, material: Material, friction: float, solver: SolverSpec) -> ContactProblem:
    """Set up the solid of a mesh with its fixed base, its outer surface and the contact law."""
    fixed = np.zeros((len(mesh.nodes), 3), bool)
    fixed[mesh.base] = True
    fixed[mesh.mirror, 0] = True
    solid = Solid(mesh.nodes, mesh.cells, material, fixed)
    first = len(mesh.cells) - len(mesh.outer_faces)
    surface = OuterSurface(mesh.nodes, mesh.outer_faces, np.arange(first, len(mesh.cells)))
    thickness = mesh.dome.thickness
    stiffness = solver.penalty_ratio * material.young_modulus / thickness
    law = ContactLaw(
        stiffness=stiffness,
        width=solver.smoothing_ratio * thickness,
        tangential_stiffness=solver.tangential_ratio * stiffness,
        friction=friction,
    )
    tolerance = solver.tolerance * material.law.shear_modulus * thickness**2
    return ContactProblem(solid, surface, law, make_linear_solver(solver.backend), tolerance, thickness)


def start_path(problem: ContactProblem, mesh: Mesh, normal: FloatArray, solver: SolverSpec) -> Path:
    """Start the flat branch: the dome at rest, the wall at first touch."""

    def plane(depth: float) -> Plane:
        return wall_at(mesh.dome, normal, depth)

    rest = problem.solid.rest()
    touch = untouched(len(problem.surface.points))
    outer = problem.surface.points
    probe = int(np.argmin(np.linalg.norm(outer - touch_point(mesh.dome, normal), axis=1)))
    return Path(problem, plane, probe, solver, [Point(0.0, rest, Loads(0.0, 0.0, np.zeros(3)), touch)])


def _fields(path: Path, images: list[int], mesh: Mesh, azimuth_deg: float) -> dict[str, Any]:
    """Arrays of the `Press` at the images."""
    problem = path.problem
    points = [path.points[k] for k in images]
    parts = 1.0 if mesh.spec.whole else 2.0
    side = np.ones(3) if mesh.spec.whole else np.array([0.0, 1.0, 1.0])
    area, peak = [], []
    for point in points:
        plane = path.wall(point.depth)
        reach = (problem.surface.interpolate(mesh.nodes + point.state.u) - plane.point) @ plane.normal
        area.append(parts * problem.surface.current_area(mesh.nodes + point.state.u, reach > 0))
        peak.append(von_mises(cauchy_stress(problem.solid, point.state)).max())
    inverted = [path.inverted(point.state, point.depth) for point in points]
    turn = np.eye(3) if mesh.spec.whole else azimuth_rotation(azimuth_deg)
    force = np.array([parts * side * point.loads.force for point in points]) @ turn.T
    return {
        "depth": np.array([point.depth for point in points]),
        "displacement": np.array([point.state.u for point in points]),
        "force": force,
        "energy": np.array([parts * point.loads.elastic for point in points]),
        "contact_energy": np.array([parts * point.loads.contact for point in points]),
        "dissipation": np.array([parts * point.dissipated for point in points]),
        "work": parts * _work(path.points)[images],
        "branch": np.where(inverted, str(Branch.INVERTED), str(Branch.FLAT)),
        "peak_stress": np.array(peak),
        "contact_area": np.array(area),
        "apex_gap": np.array([path.gap(point.state, point.depth) for point in points]),
        "hold_tension": np.array([point.tension for point in points]),
        "negative_pivots": np.array([point.negative_pivots for point in points]),
    }


def _work(points: list[Point]) -> FloatArray:
    """Work (n,) mJ of the wall at every equilibrium, from the energy stored at the first.

    The axial force is integrated by cubic splines between jumps and turns of the wall, by the trapezoid in a jump.
    """
    depth = np.array([point.depth for point in points])
    force = np.array([point.loads.force[2] for point in points])
    jumps = {k for k, point in enumerate(points) if point.jumped and k > 0}
    turns = {k for k in range(1, len(points) - 1) if (depth[k + 1] - depth[k]) * (depth[k] - depth[k - 1]) < 0}
    gained = np.zeros(len(points))
    for first, last in pairwise(sorted({0, len(points) - 1} | jumps | {k - 1 for k in jumps} | turns)):
        gained[first + 1 : last + 1] = np.diff(_integrate(depth[first : last + 1], force[first : last + 1]))
    work: FloatArray = sum(points[0].loads[:2]) + np.cumsum(gained)
    return work


def _integrate(depth: FloatArray, force: FloatArray) -> FloatArray:
    """Integral (n,) mJ of a force (n,) N over depths (n,) mm that rise or fall."""
    if len(depth) <= 3:
        steps = 0.5 * (force[1:] + force[:-1]) * np.diff(depth)
        return np.concatenate([[0.0], np.cumsum(steps)])
    way = np.sign(depth[-1] - depth[0])
    whole = CubicSpline(way * depth, force).antiderivative()(way * depth)
    result: FloatArray = way * (whole - whole[0])
    return result
