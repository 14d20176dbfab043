"""The mesh of what fills a skin: held against volumes of revolution, against itself, and by the patch test."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.special import gamma

from errors import refused
from palpate.design import ConeSpec, DomeSpec, SkinSpec, SplineSpec, rotation_vector, wall_normal
from palpate.design.flat_pad import FlatPadSpec
from palpate.fea import Branch, DeckSpec, Dialect, WallSpec, read_press, write_deck, write_press
from palpate.fea.deck_spec import DeckElement
from palpate.fea.nodal_stress import nodal_von_mises
from palpate.material import get_material
from palpate.mechanics import Solid, SolverSpec, State, System
from palpate.mesh import Mesh, MeshSpec, centre_mesh, measure_quality, mesh_skin
from presses import solve_press

SKINS = [
    DomeSpec(),
    DomeSpec(height=10, thickness=1),
    DomeSpec(height=28, thickness=3),
    ConeSpec(height=25, base_radius=12, thickness=1, edge_radius=12),
    SplineSpec(height=16, points=((0.5, 0.92), (0.9, 0.5)), taper=1.5),
]
FACES = [
    [9 * k + 3 * j for k in (0, 2) for j in (0, 2)],
    [9 * k + 3 * j + 2 for k in (0, 2) for j in (0, 2)],
    [9 * k + i for k in (0, 2) for i in (0, 2)],
    [9 * k + 6 + i for k in (0, 2) for i in (0, 2)],
    [3 * j + i for j in (0, 2) for i in (0, 2)],
    [18 + 3 * j + i for j in (0, 2) for i in (0, 2)],
]
"""Corners of the six faces of a cell."""
RUBBER = get_material("neo-hooke:0.1")
COARSE = SolverSpec(edge_share=1.0)


def filled(spec: SkinSpec, whole: bool = False, cells: int = 8) -> Mesh:
    return mesh_skin(spec.build(), MeshSpec(filled=True, cells=cells, core=2, whole=whole))


@pytest.mark.parametrize("whole", [False, True])
@pytest.mark.parametrize("spec", SKINS, ids=lambda spec: spec.build().name)
def test_the_filling_has_the_volume_of_the_hollow_and_sound_cells(spec: SkinSpec, whole: bool) -> None:
    """Against Pappus' rule over a fine meridian."""
    mesh = filled(spec, whole)
    s = np.linspace(0, 1, 4001)
    x, _, z = mesh.skin.point(np.column_stack([s, 0 * s]), 0.0).T
    hollow = np.pi * np.trapezoid((x[:-1] ** 2 + x[1:] ** 2) / 2, z[0] - z[:-1])
    inside = replace(mesh, cells=mesh.cells[: mesh.filling])
    assert measure_quality(inside).volume * (1 if whole else 2) == pytest.approx(hollow, rel=1e-3)
    assert measure_quality(inside).least_scaled_jacobian > 0.25
    assert measure_quality(replace(mesh, cells=mesh.cells[mesh.filling :])).least_scaled_jacobian > 0.25


@pytest.mark.parametrize("whole", [False, True])
def test_cells_join_without_gaps(whole: bool) -> None:
    """Every face has two cells, or lies outside, on the base or on the mirror plane."""
    mesh = filled(SKINS[0], whole)
    corners = np.sort(np.concatenate([mesh.cells[:, face] for face in FACES]), axis=1)
    count = Counter(map(tuple, corners))
    assert set(count.values()) == {1, 2}
    outer = set(map(int, mesh.outer_faces.ravel()))
    for face in (face for face, number in count.items() if number == 1):
        points = mesh.nodes[list(face)]
        on_base, on_mirror = np.abs(points[:, 2]).max() < 1e-9, np.abs(points[:, 0]).max() < 1e-9
        assert on_base or (on_mirror and not whole) or outer.issuperset(face)
    assert np.array_equal(np.unique(mesh.cells), np.arange(len(mesh.nodes)))
    assert np.array_equal(np.sort(mesh.base), np.flatnonzero(np.abs(mesh.nodes[:, 2]) < 1e-9))


def test_an_even_stretch_leaves_no_force_inside() -> None:
    """The patch test: one rubber throughout, stretched alike everywhere without change of volume."""
    mesh = filled(SKINS[4], whole=True)
    F = np.diag([1.2, 1 / 1.1, 1.1 / 1.2])
    fixed = np.zeros((len(mesh.nodes), 3), bool)
    solid = Solid(mesh.nodes, mesh.cells, replace(RUBBER, gel=RUBBER), fixed, mesh.filling)
    state = State(mesh.nodes @ (F - np.eye(3)).T, solid.rest().p)
    residual = np.zeros(3 * len(mesh.nodes))
    solid.assemble(state, System(np.zeros(len(solid.pattern.column)), residual))
    force = residual.reshape(-1, 3)
    outside = np.union1d(mesh.base, mesh.outer_faces)
    inside = np.setdiff1d(np.arange(len(mesh.nodes)), outside)
    assert np.abs(force[inside]).max() < 1e-3 * np.abs(force[outside]).max()


def test_without_a_gel_worth_the_name_a_filled_skin_is_hollow() -> None:
    wall = WallSpec(tilt_deg=5, depth=1.6, contact="frictionless")
    faint = replace(get_material("neo-hooke:1e-6"), bulk_ratio=2.0)
    gelled = solve_press(filled(DomeSpec(), cells=4), replace(RUBBER, gel=faint), wall, COARSE)
    hollow = solve_press(mesh_skin(DomeSpec().build(), MeshSpec(cells=4, core=2)), RUBBER, wall, COARSE)
    stuffed = solve_press(
        filled(DomeSpec(), cells=4), replace(RUBBER, gel=get_material("neo-hooke:0.01")), wall, COARSE
    )
    assert gelled.force[-1, 2] == pytest.approx(hollow.force[-1, 2], rel=2e-3)
    assert stuffed.force[-1, 2] > 1.5 * hollow.force[-1, 2]
    markers = DomeSpec().build().inner_point([0.0, 4.0, 8.0], [0.0, 0.0, 0.0])
    assert gelled.positions(markers) == pytest.approx(hollow.positions(markers), abs=5e-3)
    assert np.linalg.norm(stuffed.positions(markers)[-1] - hollow.positions(markers)[-1], axis=-1).max() > 0.05


def test_material_and_mesh_must_agree_and_a_filled_skin_has_one_state() -> None:
    hollow = mesh_skin(DomeSpec().build(), MeshSpec(cells=6))
    with refused("mesh-not-filled"):
        solve_press(hollow, replace(RUBBER, gel=RUBBER))
    with refused("gel-missing"):
        solve_press(filled(DomeSpec(), cells=6), RUBBER)
    with refused("inverted-state-gel"):
        solve_press(filled(DomeSpec(), cells=6), replace(RUBBER, gel=RUBBER), branch=Branch.INVERTED)


def test_a_filled_press_is_read_again(tmp_path: Path) -> None:
    material = replace(RUBBER, gel=get_material("neo-hooke:0.001"))
    press = solve_press(filled(DomeSpec(), cells=4), material, WallSpec(tilt_deg=3, depth=0.8), COARSE)
    write_press(tmp_path / "press.h5", press)
    again = read_press(tmp_path / "press.h5")
    assert again.mesh.filling == press.mesh.filling > 0
    assert again.material.key_data() == press.material.key_data()
    assert np.array_equal(again.mesh.cells, press.mesh.cells)
    assert nodal_von_mises(again) == pytest.approx(nodal_von_mises(press), rel=1e-4, abs=1e-8)
    marker = again.mesh.skin.inner_point(3.0, 1.0)[None]
    assert again.positions(marker) == pytest.approx(press.positions(marker))


def test_a_deck_has_both_materials(tmp_path: Path) -> None:
    material = replace(RUBBER, gel=get_material("neo-hooke:0.001"))
    mesh = filled(DomeSpec(), cells=6)
    write_deck(tmp_path / "deck.inp", mesh, material, WallSpec(depth=0.8), DeckSpec(dialect=Dialect.CALCULIX))
    lines = (tmp_path / "deck.inp").read_text().splitlines()
    sections = [line for line in lines if line.startswith("*SOLID SECTION")]
    assert [part in section for part, section in zip(("SKIN", "GEL"), sections, strict=False)] == [True, True]
    assert "*MATERIAL, NAME=SILICONE" in lines
    assert "*MATERIAL, NAME=FILLING" in lines
    with refused("deck-filled-shell"):
        write_deck(tmp_path / "shell.inp", mesh, material, WallSpec(depth=0.8), DeckSpec(element=DeckElement.SHELL))


@pytest.mark.parametrize("azimuth_deg", [None, 0.0, 20.0, 45.0, 90.0])
def test_a_pad_is_filled_with_sound_cells_wherever_its_pole_is(azimuth_deg: float | None) -> None:
    """Against the areas of its plan at every height."""
    pad = FlatPadSpec(height=3.5, base_radius=10.4, thickness=0.5, stretch=1.2, flat_radius=7.5).build()
    mesh = mesh_skin(pad, MeshSpec(filled=True, cells=10, core=3, whole=True))
    if azimuth_deg is not None:
        mesh = centre_mesh(mesh, pad.support_point(wall_normal(*rotation_vector(0.05, np.radians(azimuth_deg)))))
    s = np.linspace(0, 1, 4001)
    x, _, z = pad.point(np.column_stack([s, 0 * s]), 0.0).T
    plan = 4 * 1.2 * gamma(1 + 1 / 6) ** 2 / gamma(1 + 2 / 6)
    hollow = plan * np.trapezoid((x[:-1] ** 2 + x[1:] ** 2) / 2, z[0] - z[:-1])
    assert measure_quality(replace(mesh, cells=mesh.cells[: mesh.filling])).volume == pytest.approx(hollow, rel=2e-3)
    assert measure_quality(mesh).least_scaled_jacobian > 0.15
    corners = np.sort(np.concatenate([mesh.cells[:, face] for face in FACES]), axis=1)
    assert set(Counter(map(tuple, corners)).values()) == {1, 2}
