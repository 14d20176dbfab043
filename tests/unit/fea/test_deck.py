"""Decks: whole, consistent, and with the numbers of the press."""

from pathlib import Path

import numpy as np
import pytest
from check_deck import cards, faults, read

from errors import refused
from palpate.design import DomeSpec, Rim, build_skin
from palpate.fea import DeckSpec, WallSpec, write_deck
from palpate.fea.deck_material import hyperelastic
from palpate.fea.write_deck import deck_text
from palpate.material import get_material
from palpate.mesh import MeshSpec, measure_quality, mesh_skin

DIALECTS = [("abaqus", "solid"), ("abaqus", "shell"), ("calculix", "solid")]
SILICONE = get_material("zaid_2024_ecoflex_00_30")
DOME = build_skin(DomeSpec(height=20, thickness=2))


def text_of(dialect: str, element: str, wall: WallSpec | None = None, mesh: MeshSpec | None = None) -> str:
    meshed = mesh_skin(DOME, mesh or MeshSpec(cells=6))
    spec = DeckSpec(dialect=dialect, element=element)  # type: ignore[arg-type]
    return deck_text(meshed, SILICONE, wall or WallSpec(tilt_deg=5), spec)


@pytest.mark.parametrize("contact", ["frictionless", "no-slip", 0.3])
@pytest.mark.parametrize(("dialect", "element"), DIALECTS)
def test_everything_a_deck_uses_is_defined(dialect: str, element: str, contact: str | float) -> None:
    for mesh in (MeshSpec(cells=6), MeshSpec(cells=6, whole=True), MeshSpec(cells=6, layers=2)):
        assert faults(text_of(dialect, element, WallSpec(tilt_deg=5, contact=contact), mesh), dialect) == []


def test_the_checker_finds_what_is_not_defined() -> None:
    text = text_of("calculix", "solid")
    assert faults(text.replace("NAME=SILICONE", "NAME=RUBBER"), "calculix") == [
        "SOLID SECTION uses material SILICONE"
    ]
    assert faults(text.replace("*STATIC", "*STATIK"), "calculix") == ["unknown keyword STATIK"]


@pytest.mark.parametrize(("dialect", "element"), DIALECTS)
def test_sets_lie_where_their_names_say(dialect: str, element: str) -> None:
    deck = read(text_of(dialect, element))
    places = {name: np.array([deck.nodes[number] for number in deck.sets[name]]) for name in SETS}
    radius = {name: np.linalg.norm(place - [0, 0, DOME.center_z], axis=1) for name, place in places.items()}
    inner, outer = (DOME.radius + 1,) * 2 if element == "shell" else (DOME.radius, DOME.outer_radius)
    assert radius["INNER"] == pytest.approx(inner)
    assert radius["OUTER"] == pytest.approx(outer)
    assert places["BASE"][:, 2] == pytest.approx(0, abs=1e-9)
    assert places["MIRROR"][:, 0] == pytest.approx(0, abs=1e-12)
    assert np.abs(places["APEX"][:, :2]).max() < 1e-9
    assert set(deck.sets["BASE"]) & set(deck.sets["MIRROR"])


SETS = ("BASE", "INNER", "OUTER", "APEX", "MIRROR")


def test_bricks_fill_the_dome() -> None:
    mesh = mesh_skin(DOME, MeshSpec(cells=16, core=4))
    deck = read(text_of("calculix", "solid", mesh=mesh.spec))
    volume = sum(
        hexahedron_volume(np.array([deck.nodes[number] for number in nodes]))
        for kind, nodes in deck.elements.values()
        if kind == "C3D20R"
    )
    assert volume == pytest.approx(measure_quality(mesh).volume, rel=0.015)  # corners alone: flat faces


def hexahedron_volume(corners: np.ndarray) -> float:
    """Volume of a brick from its corners, positive where they are in the right order; tetrahedra of its centre."""
    faces = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
    centre, total = corners[:8].mean(axis=0), 0.0
    for face in faces:
        middle = corners[list(face)].mean(axis=0)
        for a, b in zip(face, (*face[1:], face[0]), strict=True):
            total += np.linalg.det(np.array([corners[a], corners[b], middle]) - centre) / 6
    return total


@pytest.mark.parametrize("dialect", ["abaqus", "calculix"])
def test_wall_and_outer_face_look_at_each_other(dialect: str) -> None:
    deck = read(text_of(dialect, "solid"))
    corners = np.array([deck.nodes[number] for number in deck.elements[deck.sets["WALL"][0]][1][:4]])
    normal = np.cross(corners[1] - corners[0], corners[3] - corners[0])
    normal *= 1 if dialect == "abaqus" else -1  # R3D4: SPOS along the right-hand normal; C3D8: S1 against it
    normal /= np.linalg.norm(normal)
    tilt = np.radians(5)
    assert normal == pytest.approx([0, np.sin(tilt), -np.cos(tilt)], abs=1e-6)
    centre = np.array([0, 0, DOME.center_z])
    assert (centre - corners[0]) @ normal == pytest.approx(DOME.outer_radius, abs=1e-5)


def test_shell_normals_point_outward() -> None:
    deck = read(text_of("abaqus", "shell"))
    for kind, nodes in deck.elements.values():
        if kind == "S4R":
            corner = np.array([deck.nodes[number] for number in nodes])
            normal = np.cross(corner[2] - corner[0], corner[3] - corner[1])
            assert normal @ (corner.mean(axis=0) - [0, 0, DOME.center_z]) > 0


@pytest.mark.parametrize(("dialect", "element"), DIALECTS)
def test_the_wall_travels_to_the_depth_with_an_image_every_step(dialect: str, element: str) -> None:
    found = {card.keyword: card for card in cards(text_of(dialect, element, WallSpec(depth=4, depth_step=0.8)))}
    assert [float(row[0]) for row in found["TIME POINTS"].data] == pytest.approx([0.8, 1.6, 2.4, 3.2, 4.0])
    assert found["STATIC"].data == [["0.4", "4", "0.0001", "0.4"]]
    assert [row[3] for row in found["BOUNDARY"].data if len(row) > 3] == ["-4"]


@pytest.mark.parametrize(("element", "held"), [("solid", ["1, 1"]), ("shell", ["1, 1", "5, 6"])])
def test_the_mirror_plane_of_a_half_model_is_held(element: str, held: list[str]) -> None:
    text = text_of("abaqus", element)
    assert [line.removeprefix("MIRROR, ") for line in text.splitlines() if line.startswith("MIRROR, ")] == held
    assert "MIRROR" not in text_of("abaqus", element, mesh=MeshSpec(cells=6, whole=True)).replace("MIRROR plane", "")


def test_a_deck_ends_where_the_wall_reaches_the_clamp() -> None:
    mesh = mesh_skin(build_skin(DomeSpec(height=10, thickness=1)), MeshSpec(cells=6))
    text = deck_text(mesh, SILICONE, WallSpec(tilt_deg=10), DeckSpec())
    times = next(card for card in cards(text) if card.keyword == "TIME POINTS")
    assert float(times.data[-1][0]) == pytest.approx(mesh.skin.clamp_depth(np.radians(10), Rim.FLAT))


def test_a_law_no_dialect_has_is_refused_with_those_that_it_has() -> None:
    with refused("law-not-in-deck", "gent", "arruda-boyce"):
        hyperelastic(get_material("gent:0.03,80").law, 1.0)


@pytest.mark.parametrize(
    ("law", "begins"),
    [
        ("neo-hooke:0.02", ("NEO HOOKE", [0.02, 7])),
        ("mooney-rivlin:0.02,0.01", ("MOONEY-RIVLIN", [0.02, 0.01, 7])),
        ("yeoh:1,2,3", ("YEOH", [1, 2, 3, 7, 0, 0])),
        ("polynomial:1,2,0,3,0,0", ("POLYNOMIAL, N=2", [1, 2, 0, 3, 0, 7, 0])),
        ("polynomial:1,2,0,0,0,3", ("POLYNOMIAL, N=3", [1, 2, 0, 0, 0, 3, 0, 0, 0, 7, 0, 0])),
        ("arruda-boyce:0.03,2.5", ("ARRUDA-BOYCE", [0.03, 2.5, 7])),
    ],
)
def test_constants_of_laws(law: str, begins: tuple[str, list[float]]) -> None:
    assert hyperelastic(get_material(law).law, 7.0) == begins


def test_ogden_keeps_its_energy_in_the_convention_of_the_decks() -> None:
    law = get_material("ogden:0.01,2.5,-0.002,-1.5").law
    model, constants = hyperelastic(law, 7.0)
    stretches = np.array([1.7, 0.9, 1 / (1.7 * 0.9)])
    terms = zip(constants[0:4:2], constants[1:4:2], strict=True)
    theirs = sum(2 * mu / alpha**2 * ((stretches**alpha).sum() - 3) for mu, alpha in terms)
    ours = law.isochoric(np.diag(stretches)[None])[0][0]
    assert model == "OGDEN, N=2"
    assert theirs == pytest.approx(ours)
    assert constants[4:] == [7, 0]


def test_incompressibility_is_the_finite_bulk_modulus_of_the_material() -> None:
    constants = next(card for card in cards(text_of("calculix", "solid")) if card.keyword == "HYPERELASTIC").data[0]
    assert float(constants[3]) == pytest.approx(2 / SILICONE.bulk_modulus)
    assert float(constants[4]) >= 1e9


def test_calculix_shells_are_refused() -> None:
    with refused("deck-shell-stiff", "--element solid"):
        text_of("calculix", "shell")


def test_a_deck_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    mesh = mesh_skin(DOME, MeshSpec(cells=4))
    write_deck(tmp_path / "press.inp", mesh, SILICONE, WallSpec())
    assert (tmp_path / "press.inp").read_text().startswith("*HEADING")
    assert (tmp_path / "press.inp").read_text().endswith("*END STEP\n")
    with refused("folder-missing"):
        write_deck(tmp_path / "nowhere" / "press.inp", mesh, SILICONE, WallSpec())
    (tmp_path / "taken").mkdir()
    with refused("file-unwritable"):
        write_deck(tmp_path / "taken", mesh, SILICONE, WallSpec())
    assert sorted(path.name for path in tmp_path.iterdir()) == ["press.inp", "taken"]


@pytest.mark.parametrize("dialect", ["abaqus", "calculix"])
def test_a_curved_wall_is_refused_by_a_deck(dialect: str) -> None:
    with refused("deck-wall-bent"):
        text_of(dialect, "solid", WallSpec(curvature=5.0))
