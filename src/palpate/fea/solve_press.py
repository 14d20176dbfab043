"""Solution of a press of a skin by a rigid obstacle."""

from __future__ import annotations

import time
from collections.abc import Callable
from itertools import pairwise

import numpy as np

from palpate.core import FloatArray, PalpateError
from palpate.fea.branch import NEITHER, Branch
from palpate.fea.derivative import differentiate_states, follow_derivatives, gather_derivatives
from palpate.fea.inverted import RING_POINTS, explain_rejection, follow_inverted, refine_mesh
from palpate.fea.loaded_skin import POINTS_PER_SIDE, clamp_skin, load_surface
from palpate.fea.monitor import SkinMonitor
from palpate.fea.press import IncrementFields, Press
from palpate.fea.spec import SAME_MM, ObstacleSpec, check_half_model
from palpate.fea.wall import WallSpec
from palpate.fea.work import integrate_force
from palpate.material import Material
from palpate.mechanics import (
    BASE_RADIUS,
    Continuation,
    EndReason,
    Increment,
    Problem,
    SolverSpec,
    cauchy_stress,
    make_linear_solver,
    von_mises,
)
from palpate.mesh import Mesh, centre_mesh


def solve_press(
    mesh: Mesh,
    material: Material,
    obstacle: ObstacleSpec | None = None,
    solver: SolverSpec | None = None,
    branch: Branch = Branch.FLAT,
    on_increment: Callable[[float], None] | None = None,
) -> Press:
    """Solve one press from first contact to full depth.

    Parameters
    ----------
    mesh
        Half or whole skin. A half model is solved in the tilt plane and rotated to the azimuth of the wall; a whole
        one is solved with the wall at its azimuth. Unless its spec forbids it, its pole is moved to the first-contact
        point.
    material
        The elastomer.
    obstacle
        Pose, depth, depth step and contact law; a flat wall by default.
    solver
        Settings of the solver.
    branch
        Flat: pressed from rest. Inverted: followed from its onset to the full depth on a mesh a third finer (see
        `palpate.fea.inverted`); it has no increment at rest, and its work counts from the energy stored in its first.
    on_increment
        Called with the depth in mm of each increment of loading when it is solved.

    Returns
    -------
    Press
        Increments at rest, at every depth step, and at the end if it ended early, with its reason.

    Raises
    ------
    PalpateError
        If the obstacle touches the clamped rim before the skin, or misses it; a derivative does not exist; or the
        inverted branch is requested for a filled skin, an open skin or a route.
    """
    obstacle, solver = obstacle or WallSpec(), solver or SolverSpec()
    started = time.process_time()
    check_half_model(mesh, obstacle)
    if branch is Branch.INVERTED and mesh.filling:
        raise PalpateError("A filled skin has one branch only.", "Press it from rest.", code="inverted-state-gel")
    if branch is Branch.INVERTED and mesh.skin.hole:
        raise PalpateError(
            f"The inverted branch of {mesh.skin.name} is not supported, because the skin is open.",
            "Choose the flat branch.",
            code="inverted-state-skin",
        )
    if branch is Branch.INVERTED and obstacle.stop_depths:
        raise PalpateError(
            "A route cannot follow the inverted branch.", "Choose the flat branch.", code="inverted-state-route"
        )
    mesh = refine_mesh(mesh) if branch is Branch.INVERTED else mesh
    mesh = centre_mesh(mesh, obstacle.at_first_contact(mesh)[1]) if obstacle.axisymmetric else mesh
    reachable = obstacle.clamp_depth(mesh)
    goals = increment_depths(obstacle, min(obstacle.depth, reachable))
    if branch is Branch.INVERTED:
        path = start_press(mesh, material, obstacle, solver, RING_POINTS)
        increments = follow_inverted(path, goals, mesh)
        followed = differentiate_states(path, increments[1:], mesh, material, obstacle)
    else:
        path = start_press(mesh, material, obstacle, solver)
        followed = follow_derivatives(path, mesh, material, obstacle)
        increments = _press_down(path, goals, obstacle.stop_depths, on_increment)
        if obstacle.unload and path.ended is EndReason.DEPTH_REACHED:
            increments += _draw_back(path, goals, obstacle.stop_depths)
    derivatives = gather_derivatives(followed, increments, mesh, obstacle)
    ended, message = path.ended, path.message
    if ended is EndReason.DEPTH_REACHED and reachable < obstacle.depth:
        ended = EndReason.WALL_AT_CLAMP
        message = f"The wall reached the clamped rim at {reachable:.3f} mm of {obstacle.depth:g} mm."
    fields = _fields(path, increments, mesh, obstacle)
    jumps = [increment.depth for increment in path.increments if increment.jumped]
    return Press(
        mesh=mesh,
        material=material,
        obstacle=obstacle,
        solver=solver,
        **fields,
        derivatives=derivatives,
        ended=ended,
        ended_depth=path.last.depth,
        jump_depth=jumps[0] if jumps else float("nan"),
        cpu_s=time.process_time() - started,
        unknowns=len(path.problem.body.free),
        newton_iterations=path.iterations,
        message=message,
    )


def _press_down(
    path: Continuation, goals: list[float], stops: tuple[float, ...], observe: Callable[[float], None] | None
) -> list[int]:
    """Press to the depths (mm) of the increments as far as possible; return the indices of the increments.

    At the stops the path of the obstacle changes.
    """
    increments = [0]
    for goal in goals:
        if not path.advance(goal):
            if path.last.depth > path.increments[increments[-1]].depth:
                increments.append(len(path.increments) - 1)
            break
        increments.append(len(path.increments) - 1)
        if goal < goals[-1] and _is_stop(goal, stops):
            path.turn()
        if observe is not None:
            observe(goal)
    return increments


def _draw_back(path: Continuation, goals: list[float], stops: tuple[float, ...]) -> list[int]:
    """Move the wall back through the depths (mm) of the increments to first contact; return their indices."""
    increments = []
    for goal in [*reversed(goals[:-1]), 0.0]:
        if _is_stop(path.last.depth, stops):
            path.turn(-1.0)
        if not path.advance(goal):
            break
        increments.append(len(path.increments) - 1)
    return increments


def _is_stop(depth: float, stops: tuple[float, ...]) -> bool:
    return any(abs(depth - stop) < SAME_MM for stop in stops)


def increment_depths(obstacle: ObstacleSpec, deepest: float) -> list[float]:
    """Return the depths in mm of the increments after rest: every depth step, every stop, and the deepest."""
    count = int(np.floor(deepest / obstacle.depth_step + 1e-9))
    depths = [obstacle.depth_step * (k + 1) for k in range(count)]
    for stop in obstacle.stop_depths:
        depths = sorted([*(depth for depth in depths if abs(depth - stop) > SAME_MM), stop])
    if not depths or deepest - depths[-1] > SAME_MM:
        depths.append(deepest)
    return depths


def start_press(
    mesh: Mesh,
    material: Material,
    obstacle_spec: ObstacleSpec,
    solver: SolverSpec,
    points_per_side: int = POINTS_PER_SIDE,
) -> Continuation:
    """Start the flat branch: the skin at rest with its base fixed, the obstacle at first contact."""
    solid = clamp_skin(mesh, material)
    loading = load_surface(solver, mesh, material, obstacle_spec, points_per_side)
    obstacle, touched = obstacle_spec.at_first_contact(mesh)
    probe = int(np.argmin(np.linalg.norm(loading.surface.points - touched, axis=1)))
    thickness, unit = mesh.skin.thickness, mesh.skin.base_radius / BASE_RADIUS
    monitor = SkinMonitor(solid, loading, probe, obstacle.gap(touched[None]).normal[0], thickness, unit)
    tolerance = solver.tolerance * material.law.shear_modulus * thickness**2
    problem = Problem(solid, make_linear_solver(solver.backend), tolerance, thickness)
    path = Continuation(problem, loading, monitor, solver, unit)
    if solver.adhesion == 0:
        path.release()
    return path


def _fields(path: Continuation, increments: list[int], mesh: Mesh, wall: ObstacleSpec) -> IncrementFields:
    """Return the arrays of the `Press` at the increments."""
    monitor = path.monitor
    assert isinstance(monitor, SkinMonitor)
    points = [path.increments[k] for k in increments]
    parts = 1.0 if mesh.spec.whole else 2.0
    side = np.ones(3) if mesh.spec.whole else np.array([0.0, 1.0, 1.0])
    area, peak = [], []
    for point in points:
        touching = monitor.loading.touching(point.depth, point.state)
        area.append(parts * monitor.loading.surface.current_area(mesh.nodes + point.state.u, touching))
        peak.append(von_mises(cauchy_stress(monitor.solid, point.state)).max())
    labels = [_label(monitor, point) for point in points]
    force = np.array([parts * side * point.loads.force for point in points]) @ wall.turn(mesh).T
    return {
        "depth": np.array([point.depth for point in points]),
        "displacement": np.array([point.state.u for point in points]),
        "force": force,
        "energy": np.array([parts * point.loads.elastic for point in points]),
        "contact_energy": np.array([parts * point.loads.potential for point in points]),
        "dissipation": np.array([parts * point.dissipated for point in points]),
        "work": parts * _work(path.increments)[increments],
        "branch": np.array(labels),
        "peak_stress": np.array(peak),
        "contact_area": np.array(area),
        "apex_gap": np.array([monitor.gap(point.depth, point.state) for point in points]),
        "stabilisation_tension": np.array([point.tension for point in points]),
        "negative_pivots": np.array([point.negative_pivots for point in points]),
    }


def _label(monitor: SkinMonitor, point: Increment) -> str:
    """Return the branch of an increment, or `NEITHER`."""
    if not monitor.inverted(point.depth, point.state):
        return str(Branch.FLAT)
    return NEITHER if explain_rejection(monitor, point) else str(Branch.INVERTED)


def _work(points: list[Increment]) -> FloatArray:
    """Return the work (n,) mJ of the wall at every equilibrium, from the energy stored at the first.

    The power is integrated by cubic splines between jumps and reversals of the wall, and by the trapezoidal rule in a
    jump.
    """
    depth = np.array([point.depth for point in points])
    force = np.array([point.power for point in points])
    jumps = {k for k, point in enumerate(points) if point.jumped and k > 0}
    # reversals of the wall, and both points of a stop, which have one depth
    turns = {k for k in range(1, len(points) - 1) if (depth[k + 1] - depth[k]) * (depth[k] - depth[k - 1]) <= 0}
    gained = np.zeros(len(points))
    for first, last in pairwise(sorted({0, len(points) - 1} | jumps | {k - 1 for k in jumps} | turns)):
        if depth[first] != depth[last]:
            gained[first + 1 : last + 1] = np.diff(integrate_force(depth[first : last + 1], force[first : last + 1]))
    work: FloatArray = sum(points[0].loads[:2]) + np.cumsum(gained)
    return work
