"""Presses of coarse skins, one of each kind: conservation of energy, symmetry, finite differences."""

import numpy as np
import pytest

from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers, skin_from_data
from palpate.fea import BallSpec, Branch, CylinderSpec, Press, WallSpec, read_obstacle, solve_press
from palpate.fea.route import RouteSpec
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import MeshSpec, mesh_skin
from palpate.surrogate import TWIN_DERIVATIVES, TWIN_STATE, MarkerState, build_twin

MATERIAL = get_material("zaid_2024_ecoflex_00_30")
SHALLOW = {"depth": 2.0, "depth_step": 1.0}
LEANING = {"tilt_deg": 4.0, **SHALLOW}
BARREL = {"kind": "barrel"}
PAD = {
    "kind": "pad",
    "height": 3.5,
    "thickness": 0.5,
    "base_radius": 10.375,
    "stretch": 1.217,
    "squareness": 6.0,
    "flat_radius": 7.5,
}


def press(obstacle, thickness=2.0, branch=Branch.FLAT, solver=None, skin=None, **mesh) -> Press:
    built = build_skin(skin_from_data(skin) if skin else DomeSpec(height=20.0, thickness=thickness))
    return solve_press(mesh_skin(built, MeshSpec(**{"cells": 4} | mesh)), MATERIAL, obstacle, solver, branch)


SCENES = {
    "tilted": (WallSpec(tilt_deg=6.0, **SHALLOW), {}),
    "frictionless": (WallSpec(tilt_deg=6.0, contact="frictionless", **SHALLOW), {}),
    "friction": (WallSpec(tilt_deg=9.0, azimuth_deg=40.0, contact=0.6, unload=True, **SHALLOW), {"whole": True}),
    "curved": (
        WallSpec(tilt_deg=4.0, lateral_rate=0.1, twist_rate_deg=1.0, curvature=5.0, **SHALLOW),
        {"whole": True},
    ),
    "lateral": (WallSpec(tilt_deg=2.0, lateral_rate=0.2, contact=0.3, **SHALLOW), {"whole": True}),
    "ball": (BallSpec(radius=6.0, offset=3.0, **SHALLOW), {}),
    "ball with friction": (BallSpec(radius=8.0, contact=0.5, **SHALLOW), {}),
    "cylinder": (CylinderSpec(**SHALLOW), {}),
    "cylinder aside": (CylinderSpec(offset=2.0, azimuth_deg=30.0, **SHALLOW), {"whole": True}),
    "edge": (read_obstacle("edge", WallSpec(**SHALLOW)), {}),
    "edge aside": (read_obstacle("edge:offset=2,azimuth_deg=40", WallSpec(**SHALLOW)), {"whole": True}),
    "plate": (read_obstacle("plate:hole_diameter=6", WallSpec(**SHALLOW)), {}),
    "plate aside": (
        read_obstacle("plate:tilt_deg=4,sink_diameter=8,offset_across=2", WallSpec(**SHALLOW)),
        {"whole": True},
    ),
    "route": (RouteSpec(waypoints=((2.0, 0.3), (2.0, 0.3, 0.2, 2.0)), depth_step=1.0), {"whole": True}),
    "inverted": (WallSpec(tilt_deg=2.0, depth=8.0, depth_step=4.0), {"thickness": 1.0, "branch": Branch.INVERTED}),
    "snap": (WallSpec(depth=8.0, depth_step=4.0), {"thickness": 1.0}),
    "pad": (WallSpec(tilt_deg=2.0, azimuth_deg=30.0, depth=0.4, depth_step=0.2), {"skin": PAD, "whole": True}),
    "barrel": (
        read_obstacle("side_wall:tilt_deg=91", WallSpec(depth=1.0, depth_step=1.0, contact="frictionless")),
        {"skin": BARREL, "cells": 8, "core": 2},
    ),
}


COARSE = {"route": 0.3, "snap": 0.6, "pad": 0.2}
"""Share of the work that long increments, or a snap-through, leave out of the balance; of other scenes 4 %."""


@pytest.mark.parametrize("scene", SCENES)
def test_work_is_stored_or_dissipated(scene: str) -> None:
    obstacle, options = SCENES[scene]
    found = press(obstacle, **options)
    kept = found.energy + found.contact_energy + found.dissipation
    error = np.abs(np.diff(kept, prepend=0.0).cumsum() - found.work)
    assert error.max() <= COARSE.get(scene, 0.04) * np.abs(found.work).max()
    assert np.all(found.dissipation >= -1e-12)
    assert np.all(found.contact_area >= 0.0)


def test_a_turned_wall_moves_a_turned_skin() -> None:
    straight, turned = (press(WallSpec(tilt_deg=5.0, azimuth_deg=a, **SHALLOW), whole=True) for a in (0.0, 90.0))
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    np.testing.assert_allclose(turned.force, straight.force @ turn.T, atol=1e-3 * straight.force.max())
    np.testing.assert_allclose(turned.energy, straight.energy, rtol=1e-3)
    np.testing.assert_allclose(turned.contact_area, straight.contact_area, rtol=1e-2)


def coarse_presses(contacts: tuple[float | str, ...], depth_step: float = 0.5) -> list[Press]:
    solver = SolverSpec(derivatives=TWIN_DERIVATIVES)
    return [
        press(WallSpec(tilt_deg=tilt, contact=contact, depth=2.0, depth_step=depth_step), solver=solver)
        for contact in contacts
        for tilt in (0.0, 5.0, 10.0)
    ]


def test_a_twin_returns_its_presses_and_the_slope_between_them() -> None:
    presses = coarse_presses(("no-slip", 1.4, 0.8))
    twin, nodes = build_twin(presses), presses[1].mesh.inner_faces.ravel()[::7]
    for found in presses[4:]:
        printed, tilt = twin.with_markers(found.mesh.nodes[nodes]), found.obstacle.tilt_deg
        slip = 1.0 / found.obstacle.friction
        for number in range(1, len(found.depth) - 1):
            here = printed.evaluate(np.array([tilt, 0.0, found.depth[number]]), slip)
            np.testing.assert_allclose(here.force, found.force[number], atol=3e-4)
            moved = found.mesh.nodes[nodes] + found.displacement[number][nodes]
            np.testing.assert_allclose(here.positions, moved, atol=6e-2)
    printed = twin.with_markers(place_markers(presses[0].mesh.skin, MarkerSpec(count=19)).positions)
    state, steps = np.array([4.0, -3.0, 1.3, 0.6, 0.02, 2.0, 0.1, -0.05, 0.8]), 1e-5

    def at(values: np.ndarray) -> MarkerState:
        pose, (slip, thickness, curvature), lateral = np.split(values, [3, 6])
        return printed.evaluate(pose, float(slip), float(thickness), lateral, float(curvature))

    here = at(state)
    assert here.jacobian.names == TWIN_STATE
    for column in range(len(state)):
        step = steps * np.eye(len(state))[column]
        low, high = at(state - step), at(state + step)
        by, force_by = (high.positions - low.positions) / (2 * steps), (high.force - low.force) / (2 * steps)
        np.testing.assert_allclose(here.jacobian.values[..., column], by, atol=1e-6, rtol=1e-4)
        np.testing.assert_allclose(here.force_jacobian.values[:, column], force_by, atol=1e-7, rtol=1e-4)
