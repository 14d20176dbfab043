"""Walls on routes, held against walls that descend, against each other by another way, and by their work."""

import numpy as np
import pytest

from errors import refused
from palpate.design import DomeSpec, MarkerSpec, place_markers
from palpate.fea import Branch, Press, WallSpec, obstacle_from_data, read_obstacle
from palpate.fea.route import RouteSpec, Waypoint
from palpate.fea.spec import ObstacleSpec
from palpate.fea.write_deck import deck_text
from palpate.material import get_material
from palpate.mechanics import SolverSpec
from palpate.mesh import Mesh, MeshSpec, mesh_skin
from presses import solve_press

SKIN = DomeSpec(height=20, thickness=2).build()
MESH, FINE = (mesh_skin(SKIN, MeshSpec(cells=cells, whole=True, centred=False)) for cells in (5, 8))
MARKERS = place_markers(SKIN, MarkerSpec(count=37)).positions
ECOFLEX = get_material("zaid_2024_ecoflex_00_30")


def press(wall: ObstacleSpec, mesh: Mesh = MESH, edge_share: float = 1.0) -> Press:
    # what holds the flat patch to the wall would bear on the force, and not on the limit of friction
    return solve_press(mesh, ECOFLEX, wall, SolverSpec(adhesion=0, edge_share=edge_share))


def route(contact: str | float, *waypoints: tuple[float, ...], edge_share: float = 1.0, **more: float) -> Press:
    return press(RouteSpec(waypoints=waypoints, contact=contact, depth_step=0.5, **more), edge_share=edge_share)


def imbalance(pressed: Press) -> float:
    """Greatest difference between the wall's work and what is stored or lost, over the greatest work."""
    kept = pressed.energy + pressed.contact_energy + pressed.dissipation
    return float(np.abs(pressed.work - kept).max() / np.abs(pressed.work).max())


def test_a_route_straight_down_is_a_press() -> None:
    ours, plain = route(0.5, (3.0, 0, 0, 5)), press(WallSpec(tilt_deg=5, depth=3, depth_step=0.5, contact=0.5))
    assert ours.positions(MARKERS)[-1] == pytest.approx(plain.positions(MARKERS)[-1], abs=1e-6)
    assert ours.work[-1] == pytest.approx(plain.work[-1], rel=1e-4)


def test_a_route_down_and_aside_is_a_wall_that_drifts() -> None:
    ours = route("no-slip", (3.0, 0.6, 0, 0, 0, 3), edge_share=0.4)
    plain = press(WallSpec(depth=3, depth_step=0.5, lateral_rate_across=0.2, twist_rate_deg=1.0), edge_share=0.4)
    # their increments are not of one length, and what sticks remembers them
    assert ours.positions(MARKERS)[-1] == pytest.approx(plain.positions(MARKERS)[-1], abs=0.01)
    assert ours.force[-1] == pytest.approx(plain.force[-1], abs=0.02 * plain.force[-1, 2])


def test_without_friction_the_way_to_a_place_does_not_matter() -> None:
    """Pressed straight, then tilted about the contact: the wall that comes tilted to the same plane."""
    ours = route("frictionless", (3.0,), (3.0, 0, 0, 6))
    normal = np.array([0.0, -np.sin(np.radians(6)), np.cos(np.radians(6))])
    depth = 3.0 + (SKIN.support_point(normal) - SKIN.support_point(np.array([0.0, 0.0, 1.0]))) @ normal / normal[2]
    plain = press(WallSpec(tilt_deg=6, depth=float(depth), depth_step=0.5, contact="frictionless"))
    assert ours.positions(MARKERS)[-1] == pytest.approx(plain.positions(MARKERS)[-1], abs=2e-4)
    assert ours.force[-1] == pytest.approx(plain.force[-1], abs=1e-3 * plain.force[-1, 2])
    assert ours.energy[-1] == pytest.approx(plain.energy[-1], rel=1e-3)
    assert imbalance(ours) < 0.01


def test_a_wall_that_twists_without_friction_does_nothing() -> None:
    ours = route("frictionless", (2.0,), (2.0, 1.0, 0, 0, 0, 20))
    at = int(np.argmin(np.abs(ours.depth - 2.0)))
    assert ours.positions(MARKERS)[-1] == pytest.approx(ours.positions(MARKERS)[at], abs=1e-5)
    assert ours.work[-1] == pytest.approx(ours.work[at], rel=1e-6)


@pytest.mark.parametrize("contact", ["no-slip", 0.4])
def test_pressed_then_slid_the_work_is_stored_or_lost(contact: str | float) -> None:
    ours = route(contact, (3.0,), (3.0, 0, 2.0))
    assert ours.ended_depth == pytest.approx(5.0)
    assert imbalance(ours) < 0.02
    aside, down = np.hypot(*ours.force[-1, :2]), ours.force[-1, 2]
    assert ours.force[-1, 1] < 0  # the wall is dragged back
    if contact == "no-slip":
        assert ours.dissipation[-1] == pytest.approx(0.0, abs=1e-9)
        assert aside > 0.5 * down
    else:
        assert ours.dissipation[-1] > 0.1 * (ours.work[-1] - ours.work[6])
        assert aside == pytest.approx(0.4 * down, rel=0.01)


def test_what_sticks_comes_back_with_the_wall() -> None:
    ours = route("no-slip", (3.0,), (3.0, 0.8), (3.0,))
    there, back = int(np.argmin(np.abs(ours.depth - 3.0))), len(ours.depth) - 1
    away = int(np.argmin(np.abs(ours.depth - 3.8)))
    moved = np.abs(ours.displacement[away] - ours.displacement[there]).max()
    assert np.abs(ours.displacement[back] - ours.displacement[there]).max() < 0.05 * moved
    slipped = route(0.2, (3.0,), (3.0, 0.8), (3.0,))
    assert np.abs(slipped.displacement[-1] - slipped.displacement[there]).max() > 0.2 * moved


def test_a_route_is_drawn_back_by_the_way_it_came() -> None:
    """Without friction every place on the way back is that on the way out, and all work is given back."""
    waypoints = ((3.0,), (3.0, 0, 0, 5), (2.0, 0, 0, 5))
    ours = press(RouteSpec(waypoints=waypoints, contact="frictionless", depth_step=0.5, unload=True), FINE)
    deepest = int(np.argmax(ours.depth))
    assert ours.depth[: deepest + 1] == pytest.approx(ours.depth[-1 : deepest - 1 : -1])
    there, back = ours.positions(MARKERS)[: deepest + 1], ours.positions(MARKERS)[-1 : deepest - 1 : -1]
    assert back == pytest.approx(there, abs=5e-4)
    assert ours.work[-1] == pytest.approx(0.0, abs=0.01 * ours.work.max())
    assert imbalance(ours) < 0.01


def test_what_sticks_and_is_drawn_back_by_its_route_is_left_as_it_was() -> None:
    ours = route("no-slip", (3.0,), (3.0, 0.8), unload=True)
    there, back = np.flatnonzero(np.abs(ours.depth - 3.0) < 1e-9)
    away = int(np.argmax(ours.depth))
    moved = np.abs(ours.displacement[away] - ours.displacement[there]).max()
    assert np.abs(ours.displacement[back] - ours.displacement[there]).max() < 0.05 * moved
    assert imbalance(ours) < 0.02
    assert ours.depth[-1] == 0.0


def test_a_route_is_read_from_words_and_from_data() -> None:
    spec = read_obstacle("route:waypoints=4 0 0 0 5; 4 2", WallSpec(contact=0.5))
    assert isinstance(spec, RouteSpec)
    assert spec.waypoints == (Waypoint(4, ry_deg=5), Waypoint(4, 2))
    assert spec.contact == 0.5
    assert obstacle_from_data(spec.model_dump(mode="json")) == spec
    # down by 4 mm, then aside by 2 while a tilt of 5° goes back, which counts 20 mm times its angle
    assert spec.depth == pytest.approx(4 + np.hypot(2, 20 * np.radians(5)))
    assert spec.waypoint(4.0) == pytest.approx(spec.waypoints[0])


@pytest.mark.parametrize(
    ("waypoints", "says"),
    [
        ("4 0 0 x", ("waypoints-malformed",)),
        ([[1, 2, 3, 4, 5, 6, 7]], ("waypoints-malformed",)),
        ([[4], [4]], ("waypoint-twice", "2")),
        ([[0, 0, 0, 5]], ("waypoint-twice", "1")),
        ([[-1]], ("waypoint-out-of-bounds", "1", "depth_mm", "-1")),
        ([[3, 0, 0, 40]], ("waypoint-out-of-bounds", "rx_deg", "40")),
        ([[float("nan")]], ("waypoint-out-of-bounds", "depth_mm", "nan")),
        ([], ("waypoints-none", "1")),
    ],
)
def test_waypoints_that_are_none_are_refused(waypoints: object, says: tuple[str, ...]) -> None:
    with refused(*says):
        RouteSpec(waypoints=waypoints)


def test_half_a_mesh_a_depth_beyond_the_clamp_and_the_inverted_state_are_refused() -> None:
    half = mesh_skin(SKIN, MeshSpec(cells=8))
    with refused("mesh-whole-needed"):
        solve_press(half, ECOFLEX, RouteSpec())
    with refused("route-reaches-rim"):
        route("no-slip", (30.0,))
    with refused("inverted-state-route"):
        solve_press(MESH, ECOFLEX, RouteSpec(), branch=Branch.INVERTED)


def test_a_wall_that_tilts_once_it_is_down_is_refused_where_it_cuts_the_rim() -> None:
    """At 14.5 mm a wall that came tilted by 20° is clear of the clamp, one that tilts only there is not."""
    RouteSpec(waypoints=[[14.5, 0, 0, 20]]).path(MESH)
    with refused("route-reaches-rim", "2", "15.9", "20"):
        RouteSpec(waypoints=[[14.5], [14.5, 0, 0, 20]]).path(MESH)
    low = mesh_skin(DomeSpec(height=4, thickness=2).build(), MeshSpec(cells=8, whole=True))
    with refused("rim-touched-first", "30"):
        RouteSpec(waypoints=[[1], [1, 0, 0, 30]]).path(low)


def test_a_route_is_refused_by_a_deck() -> None:
    with refused("deck-wall-drifts", "2"):
        deck_text(MESH, ECOFLEX, RouteSpec())
