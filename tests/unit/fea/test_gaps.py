"""Gaps of obstacles against distances that are measured otherwise, and the small functions that decide a press."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation

from errors import refused
from palpate.design import DomeSpec
from palpate.fea import Ball, Cylinder, Plane, WallSpec
from palpate.fea.edge import Edge
from palpate.fea.inverted import mirror_displacement
from palpate.fea.monitor import patch_middle, tilt_way
from palpate.fea.spec import GREATEST_FRICTION, check_contact
from palpate.fea.wall import drifting, refuse_rim_first, slope_ways
from palpate.fea.work import integrate_force
from palpate.mechanics import Obstacle
from palpate.mesh import MeshSpec, mesh_skin

RNG = np.random.default_rng(11)
MIDDLE = np.array([0.4, -0.7, 3.0])
AXIS = np.array([0.6, 0.8, 0.0])
POINTS = MIDDLE + RNG.uniform(-2.5, 2.5, (80, 3))
HALF = np.radians(35.0)


def edge_profile(share: float) -> np.ndarray:
    """Point of the edge's profile, across and up from the middle of its rounding, by the length along it, mm."""
    side, length = np.sign(share) or 1.0, abs(share)
    round_ = 1.5 * (np.pi / 2 - HALF)
    angle = min(length, round_) / 1.5
    foot = 1.5 * np.array([np.sin(angle), -np.cos(angle)])
    rest = max(length - round_, 0.0)
    foot = foot + rest * np.array([np.sin(HALF), np.cos(HALF)])
    return foot * [side, 1.0]


def edge_distance(point: np.ndarray) -> float:
    """Distance of a point from the surface of the edge, by a search along its profile."""
    arm = point - MIDDLE
    flat = np.array([arm @ np.cross([0.0, 0.0, 1.0], AXIS), arm[2]])
    best = min(
        minimize_scalar(
            lambda s: float(np.linalg.norm(edge_profile(s) - flat)),
            bounds=bounds,
            method="bounded",
            options={"xatol": 1e-9},
        ).fun
        for bounds in ((-9.0, -1.0), (-3.0, 0.0), (0.0, 3.0), (1.0, 9.0))
    )
    return float(best)


def test_the_gap_of_a_ball_a_bar_and_an_edge_is_the_distance_from_their_surface() -> None:
    ball = Ball(1.5, MIDDLE).gap(POINTS)
    assert ball.penetration == pytest.approx([1.5 - np.linalg.norm(p - MIDDLE) for p in POINTS])
    bar = Cylinder(1.5, MIDDLE, AXIS).gap(POINTS)
    assert bar.penetration == pytest.approx([1.5 - np.linalg.norm(np.cross(p - MIDDLE, AXIS)) for p in POINTS])
    edge = Edge(1.5, MIDDLE, AXIS, HALF).gap(POINTS)
    assert np.abs(edge.penetration) == pytest.approx([edge_distance(p) for p in POINTS], abs=1e-6)
    inside = [abs((p - MIDDLE) @ np.cross([0, 0, 1.0], AXIS)) for p in POINTS]
    above = (POINTS[:, 2] - MIDDLE[2]) * np.sin(HALF) - np.array(inside) * np.cos(HALF) > -1.5
    assert (edge.penetration > 0)[above & (POINTS[:, 2] > MIDDLE[2])].all()


@pytest.mark.parametrize(
    "obstacle",
    [
        Ball(1.5, MIDDLE),
        Cylinder(1.5, MIDDLE, AXIS),
        Edge(1.5, MIDDLE, AXIS, HALF),
        Plane(np.array([0.0, -0.6, 0.8]), MIDDLE, None, 0.05),
        Plane(np.array([0.0, -0.6, 0.8]), MIDDLE, None, -0.03),
        Plane(np.array([0.0, -0.6, 0.8]), MIDDLE),
    ],
    ids=["ball", "bar", "edge", "bent", "hollow", "plane"],
)
def test_normal_and_curvature_are_the_slopes_of_the_gap_and_move_with_the_obstacle(obstacle: Obstacle) -> None:
    gap, step = obstacle.gap(POINTS), 1e-6
    bend = np.zeros((80, 3, 3)) if gap.curvature is None else gap.curvature
    for axis in range(3):
        ahead, behind = POINTS + step * np.eye(3)[axis], POINTS - step * np.eye(3)[axis]
        slope = (obstacle.penetration(ahead) - obstacle.penetration(behind)) / (2 * step)
        assert gap.normal[:, axis] == pytest.approx(slope, abs=1e-6)
        turn = (obstacle.gap(ahead).normal - obstacle.gap(behind).normal) / (2 * step)
        smooth = np.abs(turn).max(axis=1) < 1e3
        assert bend[smooth][:, :, axis] == pytest.approx(turn[smooth], abs=1e-5)
    by = np.array([0.3, -0.2, 0.5])
    assert obstacle.moved(by).penetration(POINTS + by) == pytest.approx(gap.penetration)
    reach, place = obstacle.closest_points(POINTS)
    assert reach == pytest.approx(gap.penetration)
    assert obstacle.penetration(obstacle.point + place) == pytest.approx(np.zeros(80), abs=1e-6)


def test_a_bent_wall_is_a_ball_that_touches_its_point() -> None:
    normal = np.array([0.0, -0.6, 0.8])
    for curvature in (0.05, -0.05):
        centre = MIDDLE + normal / curvature
        away = np.linalg.norm(POINTS - centre, axis=1)
        wanted = (1 / curvature - away) if curvature > 0 else (away + 1 / curvature)
        assert Plane(normal, MIDDLE, None, curvature).penetration(POINTS) == pytest.approx(wanted)
    nearly = Plane(normal, MIDDLE, None, 1e-9).penetration(POINTS)
    assert nearly == pytest.approx(Plane(normal, MIDDLE).penetration(POINTS), abs=1e-7)
    with refused("wall-bent-no-facets"):
        Plane(normal, MIDDLE, None, 0.05).patch(MIDDLE, 1.0)


def test_points_that_stick_to_a_twisted_wall_turn_with_it() -> None:
    normal = np.array([0.0, -0.6, 0.8])
    wall = Plane(normal, MIDDLE)
    turned = wall.twisted(0.3).twisted(0.2)
    turn = Rotation.from_rotvec(0.5 * normal).as_matrix()
    carried = MIDDLE + (POINTS - MIDDLE) @ turn.T
    assert turned.closest_points(carried)[1] == pytest.approx(wall.closest_points(POINTS)[1])
    assert turned.penetration(carried) == pytest.approx(wall.penetration(POINTS))
    moved = drifting(lambda depth: wall.moved(depth * -normal), np.array([0.1, 0.0, 0.0]), 0.05, 2.0)
    assert moved.point == pytest.approx(MIDDLE - 2 * normal + [0.2, 0, 0])
    assert moved.axes == pytest.approx(Rotation.from_rotvec(0.1 * normal).as_matrix())


def test_ways_along_and_across_a_slope_are_at_right_angles_and_uphill() -> None:
    azimuth = 0.7
    across = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
    normal = Rotation.from_rotvec(0.2 * across).as_matrix() @ [0.0, 0.0, 1.0]
    along, found = slope_ways(normal, azimuth)
    assert found == pytest.approx(across)
    assert [along @ found, along @ normal, np.linalg.norm(along)] == pytest.approx([0, 0, 1], abs=1e-12)
    assert np.linalg.det([along, found, normal]) == pytest.approx(-1.0) or np.linalg.det(
        [found, along, normal]
    ) == pytest.approx(-1.0)
    assert tilt_way(np.array([0.0, 0.0, 1.0])) == pytest.approx([0, 1, 0])
    assert tilt_way(np.array([0.0, -0.6, 0.8])) == pytest.approx([0, 0.8, 0.6])
    assert abs(tilt_way(np.array([0.0, 1.0, 0.0])) @ [0, 0, 1]) == pytest.approx(1.0)


def test_a_wall_as_steep_as_the_rim_touches_it_first() -> None:
    mesh = mesh_skin(DomeSpec(height=10, base_radius=20).build(), MeshSpec(cells=5))
    rim = float(np.degrees(mesh.skin.rim_slope(mesh.spec.rim)))
    refuse_rim_first(mesh, rim - 1e-6)
    with refused("rim-touched-first", f"{rim:.3g}"):
        refuse_rim_first(mesh, rim + 1e-9)


@pytest.mark.parametrize(
    ("given", "law"),
    [
        ("no-slip", "no-slip"),
        ("frictionless", "frictionless"),
        (0, "frictionless"),
        ("0.5", 0.5),
        (GREATEST_FRICTION, GREATEST_FRICTION),
    ],
)
def test_a_contact_law_is_a_word_or_a_coefficient(given: object, law: object) -> None:
    assert check_contact(given) == law
    assert WallSpec(contact=given).contact == law


@pytest.mark.parametrize(
    ("given", "code"),
    [
        ("sticky", "contact-unknown"),
        (None, "contact-unknown"),
        (-0.01, "friction-out-of-bounds"),
        (10.01, "friction-out-of-bounds"),
        (float("inf"), "friction-out-of-bounds"),
    ],
)
def test_another_contact_law_is_refused(given: object, code: str) -> None:
    with refused(code, str(given)):
        WallSpec(contact=given)


def test_the_middle_of_a_patch_is_within_nine_tenths_of_its_smallest_radius() -> None:
    grid = np.stack(np.meshgrid(*[np.linspace(-3, 3, 61)] * 2), axis=-1).reshape(-1, 2)
    place = np.column_stack([grid, np.full(len(grid), 5.0)])
    away = np.hypot(*grid.T)
    touching = away < 2.0
    middle = patch_middle(place, np.array([0.0, 0.0, 1.0]), touching)
    assert middle[away < 1.6].all()
    assert not middle[away > 1.9].any()
    ring = patch_middle(place, np.array([0.0, 0.0, 1.0]), touching & (grid[:, 0] > -9), np.array([0.0, 0.0, 0.0]))
    assert (ring == middle).mean() > 0.98
    assert not patch_middle(place, np.array([0.0, 0.0, 1.0]), np.arange(len(place)) < 3).any()


def test_the_mirrored_start_of_an_inverted_skin_mirrors_its_apex_and_leaves_its_rim() -> None:
    mesh = mesh_skin(DomeSpec(height=20, thickness=1).build(), MeshSpec(cells=8))
    for depth in (6.0, 9.0):
        wall = Plane(np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, mesh.skin.outer_height - depth]))
        moved = mirror_displacement(mesh, wall)
        middle = mesh.skin.point(mesh.inner_disc, 0.5, mesh.spec.rim)
        apex = np.argmin(np.linalg.norm(mesh.inner_disc, axis=1) + (mesh.nodes[:, 2] < mesh.skin.outer_height - 1e-6))
        sunk = moved[apex, 2]
        assert -2 * depth < sunk < -1.6 * (depth - 2.0)
        assert not moved[mesh.base].any()
        far = middle[:, 2] < mesh.skin.outer_height - depth - 8.0
        if far.any():
            assert np.abs(moved[far]).max() < 0.5


def test_the_wall_of_a_mirrored_skin_faces_the_obstacle_again() -> None:
    """Across the ridge the normal keeps its height over the wall, and its slope is turned round."""
    mesh = mesh_skin(DomeSpec(height=20, thickness=1).build(), MeshSpec(cells=12))
    top = mesh.skin.outer_height - 8.0
    moved = mirror_displacement(mesh, Plane(np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, top])))
    around: dict[tuple[float, float], list[int]] = {}
    for number, place in enumerate(mesh.inner_disc.round(9).tolist()):
        around.setdefault((place[0], place[1]), []).append(number)
    turned = kept = 0
    for numbers in around.values():
        inner, middle, outer = sorted(numbers, key=lambda k: np.linalg.norm(mesh.nodes[k]))
        before = mesh.nodes[outer] - mesh.nodes[inner]
        after = before + moved[outer] - moved[inner]
        slope = np.linalg.norm(before[:2])
        if mesh.nodes[middle, 2] > top + 4.0 and slope > 0.2:
            turned += 1
            assert after[:2] @ before[:2] < -0.8 * slope**2
            assert after[2] == pytest.approx(before[2], rel=0.1)
        if top - 11.0 > mesh.nodes[middle, 2]:
            kept += 1
            assert after == pytest.approx(before, abs=0.1)
    assert min(turned, kept) > 5


@pytest.mark.parametrize("back", [False, True])
def test_work_is_the_integral_of_the_force_over_the_depth_either_way(back: bool) -> None:
    depth = np.array([0.0, 0.4, 1.0, 1.3, 2.0])
    force = 1 + 2 * depth - 0.5 * depth**2 + 0.3 * depth**3
    whole = depth + depth**2 - 0.5 * depth**3 / 3 + 0.3 * depth**4 / 4
    if back:
        depth, force, whole = depth[::-1], force[::-1], whole[::-1]
    assert integrate_force(depth, force) == pytest.approx(whole - whole[0])
    assert integrate_force(depth[:3], 2 * depth[:3]) == pytest.approx(depth[:3] ** 2 - depth[0] ** 2)
    assert integrate_force(depth[:2], force[:2])[1] == pytest.approx((depth[1] - depth[0]) * force[:2].mean())


@pytest.mark.parametrize("half", [0.8, 4.0])
@pytest.mark.parametrize(
    "obstacle", [Cylinder(1.5, MIDDLE, AXIS), Edge(1.5, MIDDLE, AXIS, HALF)], ids=["bar", "edge"]
)
def test_a_patch_lies_about_the_place_that_is_touched(obstacle: Cylinder | Edge, half: float) -> None:
    at = MIDDLE + 2.3 * AXIS - [0.0, 0.0, 1.5]
    points, quads = obstacle.patch(at, half)
    along = (points - MIDDLE) @ AXIS
    assert (along.min(), along.max()) == pytest.approx((2.3 - half, 2.3 + half))
    assert obstacle.penetration(points) == pytest.approx(np.zeros(len(points)), abs=1e-9)
    across = (points - MIDDLE) @ np.cross([0.0, 0.0, 1.0], AXIS)
    assert across.min() == pytest.approx(-across.max())
    corners = points[quads]
    facing = np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])
    middle = corners.mean(axis=1)
    assert ((facing * obstacle.gap(middle).normal).sum(axis=1) > 0).all()
    length = np.linalg.norm(np.diff(points[::2], axis=0), axis=1).sum()
    round_ = 1.5 * (np.pi / 2 - HALF) if isinstance(obstacle, Edge) else 1.5 * np.pi / 2
    wanted = 2 * (half if isinstance(obstacle, Edge) else min(half, round_))
    assert length == pytest.approx(wanted, rel=0.01)
