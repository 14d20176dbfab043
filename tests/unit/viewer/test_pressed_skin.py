"""A dome between its solved tilts: exact at them, smooth between, honest where nothing was solved."""

from math import gamma
from types import SimpleNamespace

import numpy as np
import pytest
from made_up_presses import MESH, made_up_press, moved

from errors import refused
from palpate.camera import build_camera
from palpate.design import MarkerSpec, place_markers, rotation_vector, turn_about_axis, wall_normal
from palpate.design.flat_pad import FlatPadSpec
from palpate.fea import BallSpec
from palpate.mesh import MeshSpec, locate_inner, mesh_skin
from palpate.surrogate import build_field
from palpate.viewer.pressed_skin import build_pressed_skin
from palpate.viewer.shell import PARTS, build_shell

PAD = FlatPadSpec(height=3.5, base_radius=10.4, thickness=0.5, flat_radius=7.5, stretch=1.2).build()


@pytest.fixture(scope="module")
def pressed():
    return build_pressed_skin([made_up_press(tilt) for tilt in (6.0, 0.0, 3.0)])


@pytest.mark.parametrize("tilt", [0.0, 3.0, 6.0])
def test_a_solved_tilt_is_given_back(pressed, tilt):
    motion = pressed.at(tilt)
    assert motion.depths_mm.tolist() == pytest.approx([0, 0.8, 1.6, 2.4, 3.2, 4.0])
    assert motion.displacement[5] == pytest.approx(moved(MESH.nodes, tilt, 4.0), abs=1e-5)
    assert motion.force_n[-1] == pytest.approx(0.4)


@pytest.mark.parametrize("tilt", [0.4, 1.5, 4.2])
def test_between_solved_tilts_the_dome_is_that_of_the_closed_form(pressed, tilt):
    assert pressed.at(tilt).displacement[5] == pytest.approx(moved(MESH.nodes, tilt, 4.0), abs=4e-3)


def test_markers_turn_with_the_wall(pressed):
    layout, camera = place_markers(MESH.skin, MarkerSpec(count=37)), build_camera()
    motion = pressed.at(4.0)
    straight = pressed.markers(layout, camera, motion, 0.0)
    turned = pressed.markers(layout, camera, motion, 60.0)  # the rings look the same after a sixth of a turn
    angle = np.radians(60)
    rotation = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    expected = straight.positions[-1] @ rotation.T
    distance = np.linalg.norm(turned.positions[-1][:, None] - expected[None], axis=-1).min(axis=1)
    assert distance.max() < 1e-4
    assert turned.pixels.shape == (6, 37, 2)
    assert turned.seen.all()


def test_markers_of_both_halves_are_followed_in_the_domes_frame(pressed):
    layout = place_markers(MESH.skin, MarkerSpec(count=19))
    found = pressed.positions(layout, pressed.at(6.0), 0.0)[-1]
    expected = layout.positions + moved(layout.positions, 6.0, 4.0)
    assert found == pytest.approx(expected, abs=0.02)  # a coarse mesh


def test_the_surface_that_is_drawn_carries_its_markers(pressed):
    layout = place_markers(MESH.skin, MarkerSpec(count=37))
    motion, turn = pressed.at(4.3), turn_about_axis(np.radians(75.0))
    half = (layout.positions @ turn)[:, 0] > 0
    points = locate_inner(MESH, (layout.positions @ turn)[half])
    drawn = layout.positions[half] + points.interpolate(motion.displacement) @ turn.T
    off = np.abs(drawn - pressed.positions(layout, motion, 75.0)[:, half]).max()
    assert off < 1e-3  # mm: the series along a circle is cut after 40 orders


def test_nothing_is_interpolated_where_a_press_ended():
    pressed = build_pressed_skin([made_up_press(0.0), made_up_press(3.0, reached=2.0), made_up_press(6.0)])
    motion = pressed.at(2.0)
    assert motion.depths_mm[-1] == pytest.approx(1.6)
    assert motion.ended == "the branch ended"
    assert pressed.at(6.0).depths_mm[-1] == pytest.approx(4.0)


def test_the_end_of_a_press_alone_is_shown():
    motion = build_pressed_skin([made_up_press(3.0, reached=2.0)]).at(3.0)
    assert motion.depths_mm.tolist() == pytest.approx([0, 0.8, 1.6, 2.0])
    assert motion.displacement[-1] == pytest.approx(moved(MESH.nodes, 3.0, 2.0), abs=1e-5)


def test_branches_are_not_mixed():
    pressed = build_pressed_skin([made_up_press(0.0), made_up_press(3.0), made_up_press(6.0, inverted_from=3.0)])
    assert pressed.at(4.5).ended == "between the flat and the inverted branch"
    assert pressed.at(4.5).depths_mm[-1] == pytest.approx(2.4)
    assert pressed.at(6.0).branch[-1] == "inverted"
    assert pressed.at(3.0).branch[-1] == "flat"


@pytest.mark.parametrize("tilt", [-1.0, 6.1, float("nan"), float("inf")])
def test_a_tilt_that_was_not_pressed_is_refused(pressed, tilt):
    with refused("tilt-not-pressed"):
        pressed.at(tilt)


def test_the_nearest_solved_press_is_exported(pressed, pad):
    assert [pressed.nearest(tilt, 77.0).obstacle.tilt_deg for tilt in (0.0, 1.4, 1.6, 6.0)] == [0, 0, 3, 6]
    poses = {(press.obstacle.tilt_deg, press.obstacle.azimuth_deg) for press in pad.solved}
    assert {(one.tilt_deg, one.azimuth_deg) for one in (pad.nearest(*pose).obstacle for pose in poses)} == poses
    assert pad.nearest(2.0, 80.0).obstacle.azimuth_deg == 90


def test_presses_that_do_not_belong_together_are_refused():
    with refused("presses-none"):
        build_pressed_skin([])


def test_the_shell_is_closed_and_lies_on_the_two_spheres():
    shell = build_shell(MESH)
    rest = MESH.nodes[shell.nodes]
    centre = [0, 0, MESH.skin.center_z]
    for name, radius in (("outer", MESH.skin.outer_radius), ("inner", MESH.skin.radius)):
        first, count = shell.parts[name]
        used = np.unique(shell.triangles[first : first + count])
        assert np.linalg.norm(rest[used] - centre, axis=1) == pytest.approx(radius, abs=1e-6)
    corners = rest[shell.triangles]
    volume = np.einsum("ki,ki->k", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    assert volume.sum() / 6 == pytest.approx(np.pi * (22**3 - 20**3) / 3, rel=0.02)  # half a hollow hemisphere
    assert tuple(shell.parts) == PARTS
    assert sum(count for _, count in shell.parts.values()) == len(shell.triangles)
    edges = np.sort(np.concatenate([shell.nodes[shell.triangles][:, pair] for pair in ([0, 1], [1, 2], [2, 0])]))
    edges, times = np.unique(edges, axis=0, return_counts=True)
    open_edges = np.isin(edges, MESH.mirror).all(axis=1)
    assert (times == np.where(open_edges, 1, 2)).all()  # the half dome is open in its mirror plane alone


def test_cells_of_the_shell_fill_the_skin():
    shell = build_shell(MESH)
    assert (shell.nodes[shell.cells] == MESH.cells).all()
    assert set(shell.nodes) == set(range(len(MESH.nodes)))
    assert shell.triangles.max() < shell.cells.max() == len(shell.nodes) - 1, "those inside are the last"


def pad_moved(points, tilt_deg, azimuth_deg, depth):
    """Displacement (n, 3) mm under a wall: by how far each point would lie beyond it, less towards the base."""
    normal = wall_normal(*rotation_vector(np.radians(tilt_deg), np.radians(azimuth_deg)))
    height = PAD.support_height(normal[None])[0] - depth - points[:, :2] @ normal[:2] / normal[2]
    deep = (4.0 - height) * points[:, 2] / 4.0
    return np.column_stack([0.02 * points[:, 0] * deep, 0.01 * points[:, 1] * deep, -0.5 * deep])


@pytest.fixture(scope="module")
def pad():
    def press(tilt, azimuth):
        mesh = mesh_skin(PAD, MeshSpec(filled=True, cells=6, core=1, whole=azimuth > 0))
        return made_up_press(
            tilt, mesh=mesh, azimuth_deg=azimuth, move=lambda points, tilt, d: pad_moved(points, tilt, azimuth, d)
        )

    return build_pressed_skin([press(0.0, 0.0), *(press(t, a) for t in (1.0, 2.0) for a in (0.0, 45.0, 90.0))])


@pytest.mark.parametrize("pose", [(2.0, 0.0), (1.0, 45.0), (2.0, 90.0), (1.5, 20.0), (1.2, 200.0), (0.7, 305.0)])
def test_a_pad_is_drawn_whole_at_every_azimuth_in_its_own_frame(pad, pose):
    motion = pad.at(*pose)
    assert len(pad.nodes) < len(pad.mesh.nodes)  # the gel is not drawn
    assert motion.depths_mm[:4].tolist() == pytest.approx([0, 0.8, 1.6, 2.4])
    assert not motion.displacement[0].any()
    assert motion.displacement[3] == pytest.approx(pad_moved(pad.nodes, *pose, 2.4), abs=0.02)
    assert motion.displacement[3] != pytest.approx(pad_moved(pad.nodes, pose[0], pose[1] + 30, 2.4), abs=0.02)
    assert motion.normal == pytest.approx(wall_normal(*np.radians(rotation_vector(pose[0], np.radians(pose[1])))))
    assert motion.force_n[3] == pytest.approx(0.24, rel=0.05)


def test_the_surface_of_a_pad_that_is_drawn_carries_its_markers(pad):
    layout = place_markers(PAD, MarkerSpec(ring_diameters=(5.0, 10.0)))
    motion = pad.at(1.4, 75.0)
    drawn = layout.positions + locate_inner(pad.mesh, layout.positions).interpolate(motion.displacement)
    assert drawn[1:] == pytest.approx(pad.positions(layout, motion, 75.0)[1:], abs=1e-3)


@pytest.mark.parametrize("skin", ["pressed", "pad"])
def test_markers_and_forces_are_those_of_the_dataset_at_random_poses(skin, request):
    drawn = request.getfixturevalue(skin)
    layout = place_markers(drawn.mesh.skin, MarkerSpec(ring_diameters=(5.0, 10.0)))
    field = build_field(drawn.solved, layout)  # as in `palpate.datasets.randomise_field`
    rng = np.random.default_rng(5)
    compared = 0
    for tilt, azimuth in zip(rng.uniform(0.0, drawn.tilts_deg[-1], 10), rng.uniform(-180.0, 180.0, 10), strict=True):
        motion, (rx, ry) = drawn.at(tilt, azimuth), rotation_vector(tilt, np.radians([azimuth])).T
        shown = drawn.positions(layout, motion, azimuth)
        assert shown[0] == pytest.approx(layout.positions, abs=1e-9)
        for image, depth in enumerate(field.depths_mm):
            for k in np.flatnonzero(np.abs(motion.depths_mm - depth) < 1e-6):
                assert np.abs(shown[k] - field.positions(rx, ry, image)[0]).max() < 1e-9
                assert motion.force_n[k] == pytest.approx(np.linalg.norm(field.forces(rx, ry, image)[0]), abs=1e-9)
                compared += 1
    assert compared >= 30


def test_the_shell_of_a_whole_filled_pad_is_its_wall_alone_and_closed():
    mesh = mesh_skin(PAD, MeshSpec(filled=True, cells=16, core=3, whole=True))
    shell = build_shell(mesh)
    corners = mesh.nodes[shell.nodes[shell.triangles]]
    volume = np.einsum("ki,ki->k", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    along = np.column_stack([np.linspace(0, 1, 2001), np.zeros(2001)])
    half = [PAD.point(along, layer)[:, [0, 2]] for layer in (0.0, 1.0)]  # each section, carried round the plan
    under = [-np.trapezoid(section[:, 0] ** 2, section[:, 1]) for section in half]
    plan = 4 * PAD.stretch * gamma(1 + 1 / PAD.squareness) ** 2 / gamma(1 + 2 / PAD.squareness)
    assert (shell.nodes[shell.cells] == mesh.cells[mesh.filling :]).all()
    edges = np.sort(np.concatenate([shell.nodes[shell.triangles][:, pair] for pair in ([0, 1], [1, 2], [2, 0])]))
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    assert volume == pytest.approx(plan * (under[1] - under[0]), rel=0.01)


def test_presses_by_a_ball_are_not_drawn_as_those_of_a_wall() -> None:
    press = SimpleNamespace(mesh=MESH, obstacle=BallSpec())
    with refused("obstacle-not-drawn", "ball", "5", "0"):
        build_pressed_skin([press])
