"""Barrels: geometry against closed forms, a barrel upside down, and nodes of the published mesh."""

import numpy as np
import pytest

from errors import refused
from palpate.camera import build_camera
from palpate.design import (
    Dome,
    MarkerSpec,
    Rim,
    check_design,
    place_markers,
    rotation_vector,
    skin_from_data,
    wall_normal,
)
from palpate.design.barrel import Barrel, BarrelSpec
from palpate.study import read_study

TACLINK = BarrelSpec().build()
SHORT = BarrelSpec(height=60, base_radius=20, middle_radius=28, thickness=2).build()
ROWS = MarkerSpec(rows=16, around=16, pitch=15)


def ring(skin: Barrel, count: int = 200, most: float = 0.98) -> np.ndarray:
    """Places (n, 2) on the disc with a hole, away from its edges."""
    rng = np.random.default_rng(3)
    share, angle = most * rng.uniform(-0.5, 0.5, count) + 0.5, rng.uniform(0, 2 * np.pi, count)
    radius = skin.hole + (1 - skin.hole) * share
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])


skins = pytest.mark.parametrize("skin", [TACLINK, SHORT], ids=["taclink", "short"])


def test_nodes_of_the_published_mesh_lie_on_the_surfaces() -> None:
    """SimTacLS, skin-vtk.vtk: (x, z) of nodes of the inner surface; its ends are at z = -10 and -270."""
    nodes = [(49.9797502987, -135.5000787493), (41.0963048712, -46.0616194420), (36.7189612222, -254.4755554117)]
    points = np.array([[x, 0.0, z + 270.0] for x, z in nodes])
    assert TACLINK.distance(points) == pytest.approx(0.0, abs=2e-3)
    ends = TACLINK.point(np.array([[TACLINK.hole, 0.0], [0.0, 1.0]]), 1.0)
    assert ends == pytest.approx(np.array([[36.284, 0, 260], [0, 36.284, 0]]), abs=1e-3)
    assert TACLINK.arc_radius == pytest.approx(500.0, abs=0.02)
    assert TACLINK.support_point(np.array([0.0, -1.0, 0.0])) == pytest.approx([0.0, -53.361, 130.0])


def test_rows_are_those_of_the_published_markers() -> None:
    """SimTacLS, marker-vtk.vtk: 16 rows of 16; the middles of the outermost are 18.7 mm from the ends."""
    layout = place_markers(TACLINK, ROWS)
    assert len(layout) == ROWS.count == 256
    rows = layout.positions.reshape(16, 16, 3)
    assert np.ptp(rows[..., 2], axis=1) == pytest.approx(0.0, abs=1e-9)
    assert np.diff(TACLINK.arc_length(rows[:, 0])) == pytest.approx(15.0)
    assert rows[-1, 0, 2] == pytest.approx(28.69 - 10.0, abs=0.3)
    azimuth = np.arctan2(rows[..., 1], rows[..., 0])
    assert np.cos(azimuth - np.radians(22.5) * np.arange(16)) == pytest.approx(1.0)
    assert [finding.code for finding in check_design(TACLINK, layout)] == ["undercut"]


@skins
def test_the_disc_is_the_inverse_of_the_surface_and_the_wall_even(skin: Barrel) -> None:
    disc = ring(skin)
    points = skin.marked(disc)
    assert skin.disc(points) == pytest.approx(disc, abs=1e-9)
    assert skin.distance(points) == pytest.approx(0.0, abs=1e-9)
    assert skin.distance(skin.point(disc, 1.0)) == pytest.approx(skin.thickness)
    assert skin_from_data(skin.spec_data).build() == skin
    assert skin.scaled(2.0).point(disc, 0.7) == pytest.approx(2.0 * skin.point(disc, 0.7))
    for layer in (0.0, 1.0):
        ends = skin.point(np.array([[0.0, skin.hole], [0.0, -1.0]]), layer)
        assert ends[:, 2] == pytest.approx([skin.height, 0.0], abs=1e-9)


@skins
def test_normals_are_the_slopes_of_the_distance_and_carry_points_back(skin: Barrel) -> None:
    points, step = skin.marked(ring(skin)), 1e-6
    slope = [
        (skin.distance(points + step * way) - skin.distance(points - step * way)) / (2 * step) for way in np.eye(3)
    ]
    normals = skin.normal(points)
    assert normals == pytest.approx(np.stack(slope, axis=-1), abs=1e-6)
    for offset in (-3.0, 1.5):
        assert skin.nearest(points + offset * normals) == pytest.approx(points)
        assert skin.distance(points + offset * normals) == pytest.approx(offset)
    whole = skin.arc_length(points) + skin.distance_to_rim(points)
    assert whole == pytest.approx(2 * skin.arc_radius * np.arcsin(skin.height / 2 / skin.arc_radius))
    assert skin.at_arc_length(skin.arc_length(points)) == pytest.approx(np.hypot(points[:, 0], points[:, 1]))


@skins
def test_a_barrel_upside_down_is_the_same(skin: Barrel) -> None:
    disc = ring(skin)
    radius = np.hypot(*disc.T)[:, None]
    other = disc / radius * (1 + skin.hole - radius)
    for layer in (0.0, 0.5, 1.0):
        turned = skin.point(other, layer) * [1, 1, -1] + [0, 0, skin.height]
        assert turned == pytest.approx(skin.point(disc, layer), abs=1e-9)


def test_points_of_the_base_are_carried_to_the_far_half_and_through_the_opening_to_nothing() -> None:
    rho = np.linspace(TACLINK.base_radius, TACLINK.middle_radius, 20)
    points = TACLINK.inner_point(rho, 0.4)
    assert TACLINK.distance(points) == pytest.approx(0.0, abs=1e-9)
    assert (points[:, 2] >= TACLINK.height / 2).all()
    assert np.isnan(TACLINK.inner_point(np.array([0.0, 30.0, 51.0]), 0.0)[:, 2]).all()


@skins
def test_rays_hit_the_wall_they_were_drawn_to_and_nothing_beyond_either_end(skin: Barrel) -> None:
    origin = np.array([0.05, -0.02, -0.6]) * skin.base_radius
    points = skin.marked(ring(skin))
    rise = -origin[2] / (points[:, 2] - origin[2])
    seen = np.hypot(*(origin + rise[:, None] * (points - origin))[:, :2].T) < skin.base_radius
    assert seen.mean() > 0.8
    assert skin.hit(origin, points[seen] - origin) == pytest.approx(points[seen], abs=1e-6)
    assert np.isnan(skin.hit(origin, points[~seen] - origin)).all()
    through = np.array([[0.0, 0.0, 1.0], [0.01, 0.0, 1.0], [1.0, 0.0, 0.0]])
    assert np.isnan(skin.hit(origin, through)).all()


@skins
def test_a_wall_at_the_side_touches_where_the_outer_arc_is_farthest(skin: Barrel) -> None:
    outer, reach = skin.point(ring(skin, 2000, 1.0), 1.0), skin.arc_radius + skin.thickness
    for lean in (-8.0, 0.0, 3.0):
        normal = wall_normal(*rotation_vector(np.radians(90 + lean), 0.4))
        touch = skin.support_point(normal)
        assert ((outer - touch) @ normal).max() < 1e-9
        assert touch[2] == pytest.approx(skin.height / 2 - reach * np.sin(np.radians(lean)))
        edge = [
            skin.point(np.array([[np.cos(a), np.sin(a)]]) * s, 1.0)[0]
            for a in np.linspace(0, 6.3, 800)
            for s in (skin.hole, 1.0)
        ]
        way = ((touch - np.array(edge)) @ normal).min()
        assert skin.clamp_depth(np.radians(90 + lean), Rim.FLAT) == pytest.approx(way, abs=1e-3)
    most = skin.rim_slope(Rim.FLAT)
    assert skin.clamp_depth(most, Rim.FLAT) == pytest.approx(0.0, abs=1e-9)
    assert np.sin(most - np.pi / 2) == pytest.approx(skin.height / 2 / reach)


def test_a_barrel_that_hardly_bulges_is_a_cylinder() -> None:
    tube = BarrelSpec(height=200, base_radius=30, middle_radius=30.001, thickness=3).build()
    points = tube.point(ring(tube), 1.0)
    assert np.hypot(points[:, 0], points[:, 1]) == pytest.approx(33.0, abs=1e-3)
    assert tube.arc_length(tube.marked(np.array([[1.0, 0.0]]))) == pytest.approx(200.0, abs=1e-6)


def test_all_markers_are_in_sight_of_a_fisheye_and_rays_through_their_pixels_meet_them() -> None:
    camera, layout = build_camera(read_study("barrel").camera), place_markers(TACLINK, ROWS)
    assert camera.visible(layout.positions, TACLINK).all()
    starts, rays = camera.sight_lines(camera.project(layout.positions))
    assert TACLINK.hit(starts, rays) == pytest.approx(layout.positions, abs=1e-6)


def test_what_a_barrel_can_not_have_is_refused() -> None:
    with refused("skin-no-apex"):
        TACLINK.require_revolution("", "")
    with refused("rings-need-apex"):
        place_markers(TACLINK, MarkerSpec())
    with refused("rows-need-tube"):
        place_markers(Dome(20.0, 20.0, 2.0), ROWS)
    with refused("rows-too-long", "16", "20", "263"):
        place_markers(TACLINK, MarkerSpec(rows=16, around=16, pitch=20))
    for middle in (32.804, 20.0, 170.0):
        with refused("barrel-not-bulging"):
            BarrelSpec(middle_radius=middle).build()


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"rows": 3}, ("rows-not-alone", "rows", "around", "pitch")),
        ({"rows": 3, "around": 8, "pitch": 5, "ring_diameters": [10]}, ("rows-not-alone", "ring_diameters")),
        ({"rows": 3, "around": 8, "pitch": 5, "count": 7}, ("marker-count-differs", "3", "8", "7")),
        ({"rows": "x", "around": 8, "pitch": 5}, ("int_parsing",)),
    ],
)
def test_rows_that_say_too_little_or_too_much_are_refused(given: dict[str, object], says: tuple[str, ...]) -> None:
    with refused(*says):
        MarkerSpec.model_validate(given)


def test_layouts_without_rows_are_written_as_before() -> None:
    assert set(MarkerSpec().model_dump()) == {"count", "ring_diameters", "file", "diameter"}
    assert MarkerSpec.model_validate(ROWS.model_dump(mode="json")) == ROWS
