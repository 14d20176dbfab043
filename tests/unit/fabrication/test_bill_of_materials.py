"""Bill of materials and workshop sheet: their numbers, compared with the solids of the pack."""

import csv
import re

import numpy as np
import pytest

from needs import needs
from palpate.design import CadSolid, DomeSpec, MountSpec, build_contact_module, cylinder
from palpate.fabrication import FabricationPack, ProcessSpec, build_enclosure
from palpate.fabrication.enclosure import BODIES, ISO_RADIUS, LED_CABLE, M3_CLEAR, SQUEEZE, Enclosure
from palpate.fabrication.process_sheet import curing, mixing, product_name, screw_length, thread_torque
from palpate.fabrication.spec import CameraBody
from palpate.material import get_material

needs("build123d")
DRAGON_30 = get_material("marechal_2020_dragon_skin_30")
MODULE = build_contact_module(DomeSpec().build(), MountSpec())


@pytest.fixture(scope="module")
def rows(pack: FabricationPack) -> dict[str, dict[str, str]]:
    with (pack.folder / "bill_of_materials.csv").open() as file:
        return {row["part"]: row for row in csv.DictReader(file)}


@pytest.fixture(scope="module")
def enclosure() -> Enclosure:
    return build_enclosure(MODULE, 48.0, ProcessSpec())


def numbers(text: str) -> list[float]:
    return [float(one) for one in re.findall(r"\d+(?:\.\d+)?", text)]


def share(part: CadSolid, place: tuple[float, float], span: tuple[float, float], radius: float) -> float:
    """Share of a cylinder that lies in the material of a part."""
    probe = cylinder(radius, *span, place)
    return part.overlap(probe) / probe.volume


def test_the_bill_has_every_part_with_size_alternative_and_source(pack: FabricationPack, rows: dict) -> None:
    assert len(rows) == len({row["number"] for row in rows.values()})
    assert all(row[key] for row in rows.values() for key in row)
    assert {"housing", "clamp_ring", "robot_plate", "mold_core", "mold_cavity"} <= set(rows)
    sheet = (pack.folder / "instructions.md").read_text()
    assert all(f"| {row['part']} | {row['quantity']} | {row['specification']} |" in sheet for row in rows.values())


def test_volumes_and_masses_of_the_bill_are_those_of_the_solids(pack: FabricationPack, rows: dict) -> None:
    for name in ("housing", "clamp_ring", "robot_plate", "mold_core", "mold_cavity"):
        volume, mass = numbers(rows[name]["specification"])[:2]
        assert volume == pytest.approx(pack.volumes[name] / 1000, abs=0.05)
        assert mass == pytest.approx(1.24 * volume, abs=0.6)
    mixed = numbers(rows["elastomer"]["quantity"])[0]
    assert mixed == pytest.approx(1.3 * pack.volumes["module"] / 1000 / 0.999**3, abs=0.06)
    assert numbers(rows["ink"]["specification"])[0] == pytest.approx(37 * np.pi / 4 * 1.5**2 / 100, abs=0.006)


def test_screws_of_the_clamp_ring_end_in_the_plastic_of_the_housing(enclosure: Enclosure, rows: dict) -> None:
    length = numbers(rows["screw, clamp ring"]["specification"])[2]
    foot, outer = MODULE.foot, enclosure.ring[1][0]
    at = ((MODULE.flange_foot + outer) / 2 + 0.25, 0.0)
    head, housing = foot + 2.0, enclosure.parts["housing"]
    assert share(enclosure.parts["clamp_ring"], at, (head, 2.0), 5.5 / 2) == pytest.approx(0, abs=1e-9), "head"
    assert share(enclosure.parts["clamp_ring"], at, (foot, head), 5.5 / 2) > 0.5, "grip"
    assert share(housing, at, (head - length, foot), 1.2) == pytest.approx(0, abs=1e-9), "free hole"
    thread = cylinder(1.5, head - length, foot, at).cut(cylinder(1.25, head - length, foot, at))
    assert housing.overlap(thread) == pytest.approx(thread.volume, rel=1e-6), "engaged over its whole length"


@pytest.mark.parametrize("body", list(CameraBody))
def test_screws_of_the_plate_are_outside_the_robots_flange_and_beside_the_slot(body: CameraBody) -> None:
    parts = build_enclosure(MODULE, 48.0, ProcessSpec(camera_body=body)).parts
    plate, housing = parts["robot_plate"], parts["housing"]
    low = float(housing.bounds[0, 2])
    radii = np.arange(ISO_RADIUS, plate.bounds[1, 0] - 0.5, 0.05)
    middle = np.mean([r for r in radii if share(plate, (r * 0.5**0.5,) * 2, (low - 7.9, low - 7), 0.2) == 0])
    assert middle - 5.5 / 2 > ISO_RADIUS, "the key passes the robot's flange"
    for turn in np.radians([45, 135, 225, 305]):
        at = (float(middle * np.cos(turn)), float(middle * np.sin(turn)))
        assert share(plate, at, (low - 8, low), M3_CLEAR / 2 - 0.1) == pytest.approx(0, abs=1e-9)
        thread = cylinder(1.5, low, low + 8, at).cut(cylinder(1.3, low, low + 8, at))  # places are found to 0.05 mm
        assert housing.overlap(thread) == pytest.approx(thread.volume, rel=1e-6)
    m6 = (25 * 0.5**0.5,) * 2
    assert share(plate, m6, (low - 4, low), 5.0) == pytest.approx(0, abs=1e-9), "a low head is flush"


def test_seats_of_light_cable_and_camera_are_as_the_bill_says(enclosure: Enclosure, rows: dict) -> None:
    housing, seat = enclosure.parts["housing"], MODULE.foot - 3.0
    inner, outer, height = numbers(rows["LED strip"]["alternative"])
    wide, long = numbers(rows["LED strip"]["specification"])[2:]
    assert (wide, long) == (height, pytest.approx(np.pi * outer, abs=0.6))
    opening = float(housing.bounds[0, 2]) + 0.1  # the cable of the LEDs passes the shelf beside the camera
    shelf = -48.0 - BODIES[CameraBody.BOARD28].pinhole
    cable = cylinder(LED_CABLE / 2 - 0.1, opening, seat - height, (0.0, outer / 2 - 1 - LED_CABLE / 2))
    assert housing.overlap(cable) == pytest.approx(0, abs=1e-6)
    assert housing.overlap(cylinder(1.0, shelf, shelf + 4.0, (outer / 2 - 4, 0.0))) > 10, (
        "the shelf is closed elsewhere"
    )
    ring = cylinder(outer / 2 - 0.05, seat - height, seat).cut(cylinder(inner / 2, seat - height, seat))
    assert housing.overlap(ring) == pytest.approx(0, abs=1e-6)
    assert housing.overlap(cylinder(outer / 2 + 1, seat - height, seat).cut(cylinder(outer / 2, seat - 4, seat))) > 1
    wide, high = numbers(rows["cable"]["specification"])[:2]
    assert (wide, high) == (12, 8)
    assert numbers(rows["camera"]["specification"])[1:4] == [32, 32, BODIES[CameraBody.BOARD28].depth]
    lens = numbers(rows["lens"]["specification"])
    assert lens[-1] == pytest.approx(np.degrees(2 * np.arctan(0.5 * 346 / 297.38)), abs=0.5)
    assert pytest.approx(lens[2], abs=0.006) == 3.6 * 297.38 / 346


def test_the_clamp_ring_squeezes_the_flange_by_what_the_sheet_says(enclosure: Enclosure) -> None:
    low, high = MODULE.foot, 0.0
    at = (MODULE.flange_radius - 1.0, 0.3)
    gap = share(enclosure.parts["clamp_ring"], at, (low, high), 0.1) * (high - low)
    assert gap == pytest.approx(SQUEEZE, rel=1e-3)


def test_lengths_and_torques_of_screws() -> None:
    assert screw_length(2, 10) == 10
    assert screw_length(8, 10) == 16
    assert thread_torque(3, 8) == pytest.approx(0.11, abs=0.005)


def test_the_sheet_answers_the_workshop(pack: FabricationPack) -> None:
    text = (pack.folder / "instructions.md").read_text()
    assert "Rz 10 µm" in text
    core = pack.volumes["mold_core"]
    plug = core - np.pi * (MODULE.flange_foot * 1.001 + 8) ** 2 * 6
    lift = float(re.search(r"lifts the core with ([\d.]+) N", text)[1])
    assert lift == pytest.approx(9.81e-6 * 1.07 * plug, rel=0.06), "the holes of the plate left aside"
    assert "one of 2.5 mm radius and 6 of 0.75 mm" in text
    assert "from 3 to 2.8 mm" in text
    opening, deep, steep = numbers(re.search(r"passes the skin's opening \([^)]*\), .* to the base", text)[0])
    assert (opening, deep) == pytest.approx((2 * MODULE.opening_foot, MODULE.skin.height), abs=0.06)
    with (pack.folder / "markers.csv").open() as dots, (pack.folder / "orientation_mark.csv").open() as mark:
        levels = [float(row["z_mm"]) for row in (*csv.DictReader(dots), *csv.DictReader(mark))]
    assert steep == pytest.approx(np.degrees(np.arccos(min(levels) / 20)), abs=0.5), "a hemisphere of 20 mm"
    assert "`palpate calibration identify` the distance" in text
    header = (pack.folder / "mold.step").read_bytes()[:400]
    assert b"('palpate " in header
    assert b"Author" not in header


def test_pot_life_and_cure_of_one_silicone_are_not_given_for_another() -> None:
    assert numbers(mixing("zaid_2024_ecoflex_00_30", 12.0)) == [6, 6, 3, 45, 23]
    assert numbers(mixing("mine", 12.0)) == [12]
    assert numbers(curing("mine")) == []


def test_an_elastomer_without_a_product_is_named_by_its_stiffness_and_the_closest_of_the_library() -> None:
    named = product_name(get_material("neo-hooke:0.1"))
    assert "Young's modulus of 600 kPa" in named, "6 C10 of an incompressible neo-Hooke law"
    assert "Dragon Skin 30" in named
    assert numbers(named)[-1] == pytest.approx(DRAGON_30.young_modulus / 0.6, abs=0.05), "times this modulus"


def test_a_law_of_the_library_is_named_by_its_product() -> None:
    assert "Dragon Skin 10 (" in product_name(get_material("marechal_2020_dragon_skin_10"))
    named = product_name(get_material("meunier_2008_silicone"))
    assert "1088 kPa" in named
    assert "Dragon Skin 30" in named


def test_the_sheet_gives_the_gap_of_the_pins_the_volume_and_the_hours_of_printing(pack: FabricationPack) -> None:
    text = (pack.folder / "instructions.md").read_text()
    gap, tape, turns = numbers(re.search(r"The pins have .* turns", text)[0])
    assert (gap, turns * tape) == pytest.approx((0.15, 0.15)), "the gap around a pin"
    volume, allowed = numbers(re.search(r"without sprues: [\d.]+ mL ± [\d.]+", text)[0])
    assert volume == pytest.approx(pack.volumes["module"] / 1000, abs=0.005)
    assert allowed == pytest.approx(0.05 * 2 / 3 * np.pi * (22**3 - 20**3) / 1000, abs=0.006), "5 % of the dome"
    parts = sum(one for name, one in pack.volumes.items() if name != "module")
    assert numbers(re.search(r"take up to \d+ h", text)[0])[0] == pytest.approx(
        parts / (0.4 * 0.1 * 60 * 3600), abs=0.5
    )
