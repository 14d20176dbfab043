"""Decks of a wall at the side of a barrel: it moves along its own normal, in both dialects, half and whole."""

from typing import Any

import numpy as np
import pytest
from check_deck import cards, faults, read

from errors import check_values
from needs import needs_program
from palpate.core import FloatArray
from palpate.design import DomeSpec, MarkerSpec, PoseSpace, Rim, Skin, build_skin, place_markers
from palpate.design.barrel import BarrelSpec
from palpate.fea import DeckSpec, ObstacleSpec, Press, WallSpec, solve_press, solve_press_calculix
from palpate.fea.side_wall import SideWallSpec
from palpate.fea.write_deck import deck_text
from palpate.material import get_material
from palpate.mechanics import Obstacle
from palpate.mesh import Mesh, MeshSpec, centre_mesh, mesh_skin

SKIN = BarrelSpec().build()
SILICONE = get_material("neo-hooke:0.02176").with_bulk_ratio(9.667)
COARSE = MeshSpec(cells=10, core=2)


def side(tilt_deg: float, **more: Any) -> SideWallSpec:
    travel = {"depth": 2.0, "depth_step": 1.0, "contact": "frictionless"} | more
    return SideWallSpec(tilt_deg=tilt_deg, **travel)


def outward(tilt_deg: float, azimuth_deg: float = 0.0) -> FloatArray:
    """Normal (3,) of a wall turned by the tilt about (cos azimuth, sin azimuth)."""
    tilt, azimuth = np.radians(tilt_deg), np.radians(azimuth_deg)
    return np.array([np.sin(azimuth) * np.sin(tilt), -np.cos(azimuth) * np.sin(tilt), np.cos(tilt)])


def text_of(wall: ObstacleSpec, dialect: str = "abaqus", element: str = "solid", whole: bool = False) -> str:
    spec = DeckSpec(dialect=dialect, element=element)  # type: ignore[arg-type]
    return deck_text(mesh_skin(SKIN, MeshSpec(cells=10, core=2, whole=whole)), SILICONE, wall, spec)


def travel_of(text: str) -> FloatArray:
    """How far (3,) mm the wall of a deck moves; nan where nothing is said."""
    rows = [row for card in cards(text) if card.keyword == "BOUNDARY" for row in card.data if "WALL" in row[0]]
    travel = np.full(6, np.nan)
    for _, first, last, *by in rows:
        travel[int(first) - 1 : int(last)] = float(by[0]) if by else 0.0
    return travel[:3]


DIALECTS = [("abaqus", "solid"), ("abaqus", "shell"), ("calculix", "solid")]


@pytest.mark.parametrize("contact", ["frictionless", "no-slip", 0.6])
@pytest.mark.parametrize(("dialect", "element"), DIALECTS)
def test_everything_a_deck_uses_is_defined(dialect: str, element: str, contact: str | float) -> None:
    for whole in (False, True):
        text = text_of(side(92, contact=contact), dialect, element, whole)
        assert faults(text, dialect) == []
        assert "NSET=APEX" not in text


@pytest.mark.parametrize(("tilt_deg", "azimuth_deg", "whole"), [(92, 0, False), (87, 0, True), (92, 40, True)])
@pytest.mark.parametrize(("dialect", "element"), DIALECTS)
def test_the_wall_moves_by_the_depth_against_its_normal(
    dialect: str, element: str, tilt_deg: float, azimuth_deg: float, whole: bool
) -> None:
    text = text_of(side(tilt_deg, azimuth_deg=azimuth_deg), dialect, element, whole)
    assert travel_of(text) == pytest.approx(-2.0 * outward(tilt_deg, azimuth_deg), abs=1e-9)


def test_a_half_model_lies_in_the_plane_of_the_wall_whatever_its_azimuth() -> None:
    assert travel_of(text_of(side(92, azimuth_deg=40))) == pytest.approx(-2.0 * outward(92), abs=1e-9)


@pytest.mark.parametrize("dialect", ["abaqus", "calculix"])
def test_a_straight_wall_moves_along_y_and_keeps_to_it(dialect: str) -> None:
    lines = text_of(side(90), dialect).splitlines()
    wall = "WALL_REF" if dialect == "abaqus" else "WALL_NODES"
    at = lines.index(f"{wall}, 2, 2, 2")
    assert (lines[at - 1], lines[at + 1]) == (f"{wall}, 1, 1", f"{wall}, 3, 3")
    (told,) = (line for line in lines if line.startswith("**") and "+y" in line)
    check_values(told, "2 mm", "0.4 mm")


@pytest.mark.parametrize("dialect", ["abaqus", "calculix"])
def test_a_wall_that_descends_is_written_as_before(dialect: str) -> None:
    mesh = mesh_skin(build_skin(DomeSpec(height=20, thickness=2)), MeshSpec(cells=6))
    text = deck_text(mesh, SILICONE, WallSpec(tilt_deg=5, depth=4), DeckSpec(dialect=dialect))  # type: ignore[arg-type]
    wall = "WALL_REF" if dialect == "abaqus" else "WALL_NODES"
    assert f"\n*BOUNDARY\n{wall}, 1, 2\n{wall}, 3, 3, -4\n" in text
    (told,) = (line for line in text.splitlines() if line.startswith("**") and "along -z" in line)
    check_values(told, "4 mm")
    corners = np.array([read(text).nodes[number] for number in read(text).sets["WALL_NODES"]])[:4]
    assert np.linalg.norm(corners[1] - corners[0]) == pytest.approx(4 * (mesh.skin.outer_widest[0] + 2))


@pytest.mark.parametrize("dialect", ["abaqus", "calculix"])
def test_the_wall_touches_in_one_point_looks_at_the_skin_and_is_as_long(dialect: str) -> None:
    deck = read(text_of(side(92, azimuth_deg=40), dialect, whole=True))
    corners = np.array([deck.nodes[number] for number in deck.elements[deck.sets["WALL"][0]][1][:4]])
    facing = np.cross(corners[1] - corners[0], corners[3] - corners[0])
    facing *= (1 if dialect == "abaqus" else -1) / np.linalg.norm(facing)  # SPOS; S1 of a brick looks the other way
    assert facing == pytest.approx(-outward(92, 40), abs=1e-6)
    nodes = np.array([deck.nodes[number] for number in deck.sets["OUTER"]])
    before = (nodes - corners[0]) @ facing
    assert (before > 0).all()
    middle = corners.mean(axis=0)
    assert middle == pytest.approx(SKIN.support_point(outward(92, 40)), abs=1e-6)
    for edge in (corners[1] - corners[0], corners[3] - corners[0]):
        length = np.linalg.norm(edge)
        assert np.abs((nodes - middle) @ edge / length).max() < length / 2


def test_a_deck_ends_where_the_wall_reaches_the_nearer_clamp() -> None:
    times = next(card for card in cards(text_of(side(98, depth=8.0))) if card.keyword == "TIME POINTS")
    assert float(times.data[-1][0]) == pytest.approx(SKIN.clamp_depth(np.radians(98), Rim.FLAT))
    assert float(times.data[-1][0]) < 8.0


class Sliding(ObstacleSpec):
    """A side wall that comes down along the axis instead: a control."""

    kind: str = "sliding"
    tilt_deg: float = 90.0

    def check_skin(self, skin: Skin, rim: Rim = Rim.FLAT) -> None:
        """It is for barrels."""

    @property
    def label(self) -> str:
        return "sliding"

    @property
    def radial(self) -> float:
        return self.tilt_deg

    @property
    def turn_deg(self) -> float:
        return 0.0

    @property
    def pose_space(self) -> PoseSpace:
        return PoseSpace.for_side_walls()

    def at_first_contact(self, mesh: Mesh) -> tuple[Obstacle, FloatArray]:
        return side(self.tilt_deg).at_first_contact(mesh)


def centred(wall: ObstacleSpec, spec: MeshSpec = COARSE) -> Mesh:
    mesh = mesh_skin(SKIN, spec)
    return centre_mesh(mesh, wall.at_first_contact(mesh)[1])


@pytest.fixture(scope="module")
def pair() -> tuple[Press, Press]:
    wall = side(87)
    return tuple(solve(centred(wall), SILICONE, wall) for solve in (solve_press, solve_press_calculix))  # type: ignore[return-value]


@pytest.mark.slow
@needs_program("calculix-ccx")
class TestAgreement:
    def test_forces_are_along_the_normal_and_agree(self, pair: tuple[Press, Press]) -> None:
        ours, theirs = pair
        assert theirs.depth == pytest.approx(ours.depth)
        assert (theirs.branch == "flat").all()
        along = theirs.force @ outward(87)
        assert np.linalg.norm(theirs.force - along[:, None] * outward(87), axis=1).max() < 1e-3 * along[-1]
        assert along[1:] == pytest.approx(ours.force[1:] @ outward(87), rel=0.03)

    def test_work_is_the_stored_energy_and_the_patch_lies_on_the_wall(self, pair: tuple[Press, Press]) -> None:
        ours, theirs = pair
        assert theirs.work[-1] == pytest.approx(theirs.energy[-1], rel=0.02)
        assert theirs.energy[-1] == pytest.approx(ours.energy[-1], rel=0.03)
        assert np.abs(theirs.apex_gap).max() < 0.05
        assert theirs.contact_area[-1] > 10

    def test_markers_agree(self, pair: tuple[Press, Press]) -> None:
        ours, theirs = pair
        points = place_markers(SKIN, MarkerSpec(rows=8, around=8, pitch=30)).positions
        away = np.linalg.norm(theirs.positions(points)[-1] - ours.positions(points)[-1], axis=-1)
        assert np.sqrt((away**2).mean()) < 0.01 * 2.0
        assert np.abs(ours.displacement_at(points)[-1]).max() > 0.5

    def test_a_wall_that_comes_down_along_the_axis_hardly_presses(self, pair: tuple[Press, Press]) -> None:
        """A control: two millimetres along the axis are a tenth of one towards the barrel."""
        wall = Sliding(tilt_deg=87.0, depth=2.0, depth_step=1.0, contact="frictionless")
        slid = solve_press_calculix(centred(wall), SILICONE, wall)
        assert 0 < slid.force[-1] @ outward(87) < 0.1 * pair[1].force[-1] @ outward(87)

    def test_a_whole_barrel_at_an_azimuth_is_the_half_one_turned(self, pair: tuple[Press, Press]) -> None:
        wall = side(87, azimuth_deg=40, depth=1.0)
        whole = solve_press_calculix(centred(wall, MeshSpec(cells=10, core=2, whole=True)), SILICONE, wall)
        half = np.linalg.norm(pair[1].force[1])
        assert whole.force[-1] == pytest.approx(half * outward(87, 40), rel=0.01, abs=0.002 * half)
        assert whole.work[-1] == pytest.approx(whole.energy[-1], rel=0.05)
