"""The inverted branch: the skin mirrored in the wall, relaxed, followed in both directions, checked.

A thin shell deforms without stretching if a cap of it is mirrored in a plane (Pogorelov, *Bendings of Surfaces and
Stability of Shells*, 1988). Mirrored in the wall's plane, the skin touches the wall on a ring and is nearly in
equilibrium; only the width of its ridge must adjust. The search therefore does not press from rest. It relaxes the
mirrored skin at a depth at which the ridge is well away from the clamp, or else deeper, and follows the branch from
there to larger depths and back to its limit point.

A state is called inverted only if `explain_rejection` finds no fault, and if the energy of its branch is equal to the
work done.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from palpate.core import FloatArray
from palpate.fea.monitor import SECTORS, SkinMonitor
from palpate.fea.work import integrate_force
from palpate.mechanics import ContactLoading, Continuation, EndReason, Increment, Obstacle, State
from palpate.mesh import Mesh, default_core, mesh_skin

RING_POINTS = 12
"""Contact points along a side of a face: the ring is some tenths of a mm wide, a tenth of a cell.
Half changes its force by 5 %, twice by 1 %. By hand."""
_SOFTER = 0.25
"""Penalty on the ring over that of a patch.

With a stiffer penalty the load jumps between points, since the penetration of the ring is some micrometres. By hand.
"""
_FINER = 4 / 3
"""Cells of a meridian over those of a press from rest: the ring's force then varies less.
Twice changes it by 4 %, half the end of the branch. By hand."""
_RIDGE = 0.5
"""Half width of the mirrored cap's ridge, in height, over sqrt(2 d T): its width scales as sqrt(R T).
By hand."""
_CLAMPED = 1.5
"""Half width of the ridge over the height at which a point is free of the clamp. By hand."""
_SEED = 0.5
"""Depth over the skin's outer height up to which the mirrored cap's ridge is well away from the clamp.
By hand."""
_LESS = 0.85
"""Last depth tried, as a share of the maximum depth: a ridge lower down relaxes more easily. By hand."""
_CAME_BACK = "returned to it"
"""End of the reason if there is no inverted state, neither here nor at any smaller depth."""
_GAP = 0.2
"""Minimum gap of the first-contact point over the depth.

The gap is about the depth less two ridges, and smallest at the onset. By hand.
"""
_HOLE = 0.5
"""Minimum inner radius of the ring of contact over its outer one. Twice ends the branch. By hand."""
_IMBALANCE = 0.02
"""Maximum difference of gained energy and work along the branch, over the stored energy. By hand."""
_FEWEST = 3
"""Minimum number of increments of a branch: the energy check of fewer is not conclusive. By hand."""
_ONSET = 0.015
"""Increment (mm, times the unit) at which the search for the end of the branch stops. By hand."""
_FIRST, _LARGEST = 0.1, 0.5
"""First and largest increment of moving back over the thickness. By hand."""
_SAME = 1e-9
"""Difference of depth in mm that counts as zero."""


class ContactRing(NamedTuple):
    """Contact of a state, projected along the obstacle's normal, about the first-contact point.

    Attributes
    ----------
    gap
        Distance between that point and the obstacle, mm.
    inner, outer
        Minimum and maximum distance of points in contact, mm; nan without contact.
    closed
        Whether there is contact in all directions.
    """

    gap: float
    inner: float
    outer: float
    closed: bool


def mirror_displacement(mesh: Mesh, obstacle: Obstacle) -> FloatArray:
    """Return the displacement (n, 3) mm that mirrors the part beyond an obstacle in its surface.

    The middle surface at a height h over the obstacle goes to ``-w log(2 cosh(h / w))``: far below, it stays; far
    above, it is mirrored; the ridge between is rounded over w. The normal ``a n + b t`` of the skin becomes ``a n - b
    tanh(h / w) t``, so the outer surface still faces the obstacle. The volume is preserved: where the ridge is
    shortened, the skin gets thicker.
    """
    thickness = mesh.skin.thickness
    middle = mesh.skin.point(mesh.inner_disc, 0.5, mesh.spec.rim)
    normal, offset = mesh.skin.normal(middle), mesh.nodes - middle
    reach, up, _ = obstacle.gap(middle)
    width = _RIDGE * np.sqrt(2 * max(float(reach.max()), thickness) * thickness)
    height = (reach - max(np.log(2) * width - thickness / 2, 0.0)) / width
    sunk = -width * (np.abs(height) + np.log1p(np.exp(-2 * np.abs(height))) + height)
    along = np.einsum("ni,ni->n", normal, up)[:, None] * up
    turned = along - np.tanh(height)[:, None] * (normal - along)
    turned /= (turned**2).sum(axis=1, keepdims=True)
    arm = np.einsum("ni,ni->n", offset, normal)[:, None]
    free = 1 - np.exp(-((_CLAMPED * mesh.nodes[:, 2] / width) ** 2))
    moved: FloatArray = free[:, None] * (sunk[:, None] * up + arm * (turned - normal))
    moved[mesh.base] = 0.0
    moved[mesh.mirror, 0] = 0.0
    return moved


def refine_mesh(mesh: Mesh) -> Mesh:
    """Mesh the skin finer along the meridian, as the ring requires, unless its pole must stay."""
    spec = mesh.spec
    if not spec.centred or spec.cells is None:
        return mesh
    core = spec.core or default_core(mesh.skin, spec.cells, centred=True)
    return mesh_skin(mesh.skin, spec.model_copy(update={"cells": round(_FINER * spec.cells), "core": core}))


def find_contact_ring(monitor: SkinMonitor, at: float, state: State) -> ContactRing:
    """Return the ring of contact of a state at a depth in mm."""
    met = monitor.loading.contact_pair(at, state)
    touching = monitor.loading.touching(at, state)
    along, across = monitor.axes
    arm = met.points[touching] - met.points[monitor.probe]
    x, y = arm @ along, np.abs(arm @ across)
    away = np.hypot(x, y)
    sector = np.minimum((np.arctan2(y, x) / np.pi * SECTORS).astype(int), SECTORS - 1)
    closed = len(np.unique(sector)) == SECTORS
    none = float("nan")
    return ContactRing(
        monitor.gap(at, state),
        float(away.min(initial=np.inf) if len(away) else none),
        float(away.max() if len(away) else none),
        closed,
    )


def explain_rejection(monitor: SkinMonitor, increment: Increment) -> str:
    """Return the reason why an equilibrium is not the inverted state; empty if it is.

    It is inverted if the gap of the first-contact point exceeds `_GAP` of the depth, contact is a closed ring about
    that point, and no pivot of its tangent is negative.
    """
    ring = find_contact_ring(monitor, increment.depth, increment.state)
    if not ring.gap > _GAP * increment.depth:
        return f"the gap of the first-contact point is {ring.gap:.3g} mm at a depth of {increment.depth:.4g} mm"
    if not ring.inner > _HOLE * ring.outer:
        return f"contact extends to {ring.inner:.3g} mm from the first-contact point and is not a ring"
    if not ring.closed:
        return "the ring of contact is open"
    if increment.negative_pivots > 0:
        return f"it has {increment.negative_pivots} unstable modes"
    return ""


def follow_inverted(path: Continuation, goals: list[float], mesh: Mesh) -> list[int]:
    """Find the inverted state and follow it to its ends, in both directions.

    Parameters
    ----------
    path
        At rest; afterwards its increments are those of the branch in ascending depth, or only the one at rest, with
        the reason.
    goals
        Requested depths of increments, mm.
    mesh
        Mesh of the skin.

    Returns
    -------
    list of int
        The requested increments, and the first and the last of the branch.

    Notes
    -----
    Contact slides freely while the skin inverts, and points stick at the places of rest. Every state of the branch
    is therefore the one that forms at its own depth, in equilibrium for any friction and contact law. A state that
    sticks and is then moved depends on the depth at which it formed.
    """
    rest, loading = path.increments[0], path.loading
    assert isinstance(loading, ContactLoading)
    law = loading.law._replace(friction=0.0, stiffness=_SOFTER * loading.law.stiffness)
    path.loading, reason, none_to = replace(loading, law=law), "", 0.0
    for depth in _seeds(mesh, goals[-1]):
        if depth > none_to:
            path.increments = [rest]
            reason = _seed(path, mesh, depth) or _follow(path, goals, mesh.skin.thickness)
            none_to = depth if reason.endswith(_CAME_BACK) else none_to
        if not reason:
            break
    if reason:
        path.increments = [rest]
        path.ended, path.message = (
            EndReason.NO_BRANCH,
            f"No inverted state was found at {goals[-1]:.4g} mm: {reason}.",
        )
        return [0]
    at = np.array([point.depth for point in path.increments])
    wanted = np.flatnonzero(np.abs(at[:, None] - np.array(goals)).min(axis=1) < _SAME)
    return sorted({0, len(at) - 1, *wanted.tolist()})


def _seeds(mesh: Mesh, deepest: float) -> list[float]:
    """Return the depths in mm at which the mirrored skin is relaxed, in order."""
    first = min(deepest, _SEED * (mesh.skin.height + mesh.skin.thickness))
    return list(dict.fromkeys([first, (first + deepest) / 2, deepest, _LESS * deepest]))


def _seed(path: Continuation, mesh: Mesh, depth: float) -> str:
    """Relax the mirrored skin at a depth in mm as start of the path; return the reason if not inverted."""
    monitor = path.monitor
    assert isinstance(monitor, SkinMonitor)
    shape = mirror_displacement(mesh, monitor.loading.obstacle(depth))
    start = State(shape, path.problem.body.rest().p)
    gap = [np.inf]

    def hopeful(state: State) -> bool:
        gap[0] = monitor.gap(depth, state)
        return gap[0] > _GAP * depth

    if path.settle(depth, shape, start, hopeful):
        return explain_rejection(monitor, path.last)
    fate = "did not come to rest" if gap[0] > _GAP * depth else _CAME_BACK
    return f"the skin mirrored in the wall at {depth:.4g} mm {fate}"


def _follow(path: Continuation, goals: list[float], thickness: float) -> str:
    """Follow the branch from its seed back and deeper; return the reason if it is too short."""
    seed = path.last
    _draw_back(path, [goal for goal in reversed(goals) if goal < seed.depth], thickness)
    back, _ = _proved(path)
    path.increments, path.ended, path.message = [seed], EndReason.DEPTH_REACHED, ""
    path.restart()
    for goal in goals:
        if goal > seed.depth and not path.advance(goal):
            break
    deeper, wrong = _proved(path)
    if wrong:
        path.ended = EndReason.BRANCH_ENDED
        path.message = f"The inverted state was followed to {deeper[-1].depth:.4g} mm: beyond, {wrong}."
    path.increments = [replace(point, jumped=False) for point in (*reversed(back[1:]), *deeper)]
    few = len(path.increments) < _FEWEST
    return f"the state found at {seed.depth:.4g} mm could not be followed from there" if few else ""


def _draw_back(path: Continuation, goals: list[float], thickness: float) -> None:
    """Follow the branch back from its seed through depths in mm until an increment of `_ONSET` fails."""
    onset, step, goals, monitor = _ONSET * path.unit, _FIRST * thickness, [*goals, 0.0], path.monitor
    assert isinstance(monitor, SkinMonitor)
    while goals:
        known, last = list(path.increments), path.last.depth
        depth, start = _predict(path, max(goals[0], last - step), onset)
        if path.attempt(depth, start) and not explain_rejection(monitor, path.last):
            step = min(2 * (last - depth), _LARGEST * thickness)
            goals = [goal for goal in goals if goal < depth - _SAME]
            continue
        path.increments, step = known, max((last - depth) / 2, onset)
        if last - depth < onset + _SAME:
            return


def _predict(path: Continuation, depth: float, onset: float) -> tuple[float, State]:
    """Extrapolate the last three increments to a depth in mm; return the depth reached and its state.

    Near a limit point the states vary smoothly with the apex gap, and the depth is a parabola of it. If such a
    parabola is found, the state is extrapolated over the gap, up to three quarters of the way to the end of the
    parabola, but by at least `onset` mm. Otherwise it is extrapolated over the depth, at most by the previous
    increment.
    """
    monitor, known = path.monitor, path.increments[-3:]
    assert isinstance(monitor, SkinMonitor)
    at = np.array([point.depth for point in known])
    place, to = at, depth
    if len(known) == 3:
        gap = np.array([monitor.gap(point.depth, point.state) for point in known])
        bend, slope, level = np.polyfit(gap, at, 2)
        least = -slope / (2 * bend)
        end = level + slope * least / 2
        if bend > 0 and least < gap[-1] < gap[0]:
            depth = min(max(depth, end + (at[-1] - end) / 4), at[-1] - min(onset, at[-1] - depth))
            place, to = gap, least + np.sqrt(max(depth - end, (at[-1] - end) / 16) / bend)
        else:
            depth = to = max(depth, 2 * at[-1] - at[-2])
    weight = np.array([np.prod([(to - b) / (a - b) for b in place if b != a]) for a in place])
    u = sum(w * point.state.u for w, point in zip(weight, known, strict=True))
    p = sum(w * point.state.p for w, point in zip(weight, known, strict=True))
    return depth, State(u, p)


def _proved(path: Continuation) -> tuple[list[Increment], str]:
    """Return the leading increments that pass the inverted-state checks, and the reason of the end."""
    monitor, points = path.monitor, path.increments
    assert isinstance(monitor, SkinMonitor)
    stored = np.array([sum(point.loads[:2]) for point in points])
    depth, force = np.array([[point.depth, point.loads.force[2]] for point in points]).T
    missed = np.abs(stored - stored[0] - integrate_force(depth, force))
    for k, point in enumerate(points):
        wrong = explain_rejection(monitor, point)
        if missed[k] > _IMBALANCE * max(stored[0], stored[k]):
            wrong = f"energy gained and work of the wall differ by {missed[k]:.2g} mJ"
        if wrong:
            return points[:k], wrong
    return points, ""
