"""A material file is written and read back whole; a wrong one is refused with file, key and remedy."""

from dataclasses import replace
from pathlib import Path

import pytest

from errors import refused
from palpate.material import (
    Material,
    Moduli,
    Relaxation,
    get_material,
    list_materials,
    material_from_data,
    read_material,
    write_material,
)
from palpate.study import MaterialSpec, read_study

TEXTS = [
    "zaid_2024_ecoflex_00_30",
    "neo-hooke:0.0141",
    "mooney-rivlin:0.1,0.05",
    "mooney-rivlin:0.1,0.05,0.01",
    "mooney-rivlin:0.1,0.05,0.01,-0.004,0.003",
    "gent:0.03,80",
    "ogden:0.63,1.3,0.0012,5,-0.01,-2",
    "arruda-boyce:0.028,3",
    "yeoh:0.014115599999999999,0,1e-17",
]


@pytest.mark.parametrize("text", [*TEXTS, *list_materials()])
def test_a_material_is_read_back_whole(text: str, tmp_path: Path) -> None:
    material = get_material(text).with_bulk_ratio(1234.5)
    path = tmp_path / "mine.yaml"
    write_material(path, material)
    again = read_material(path)
    assert again.law.constants == material.law.constants
    assert again.key_data() == material.key_data()
    assert again.name == material.name
    assert again.source == material.source
    assert again.licence == material.licence
    assert again.quality == material.quality
    assert again.caution == material.caution
    assert again.stretch_range == material.stretch_range
    assert get_material(str(path)).key_data() == material.key_data()


GOOD = "name: mine\nlaw: yeoh\nconstants:\n  C10: 0.01\n  C20: 0.0001\n  C30: 0.000001\n"
WRONG = {
    "not YAML": ("name: [\n", ("yaml-malformed",)),
    "a list": ("- 1\n- 2\n", ("material-file-malformed",)),
    "no constants": ("name: mine\nlaw: yeoh\n", ("material-file-malformed",)),
    "an unknown key": (GOOD + "colour: red\n", ("key-unknown", "colour")),
    "an unknown law": (GOOD.replace("yeoh", "rubber"), ("kind-unknown", "law", "rubber")),
    "constants of another law": (GOOD.replace("C30", "mu"), ("law-constants-unknown", "yeoh")),
    "text for a number": (GOOD.replace("0.01", "soft"), ("value-not-number", "constants.C10", "soft")),
    "a nan": (GOOD.replace("0.01", ".nan"), ("value-not-number", "constants.C10", "nan")),
    "constants as a list": ("name: mine\nlaw: yeoh\nconstants: [1, 2, 3]\n", ("constants-not-mapping",)),
    "no stiffness": (GOOD.replace("0.01", "-0.01"), ("shear-modulus-not-positive",)),
    "a bulk ratio of 1": (GOOD + "bulk_ratio: 1\n", ("bulk-ratio-out-of-bounds", "K/mu", "1")),
    "a range of one number": (GOOD + "stretch_range: 3\n", ("stretch-range-malformed", "stretch_range")),
    "gent without a limit": (
        "name: a\nlaw: gent\nconstants: {mu: 0.1, Jm: 0}\n",
        ("law-constant-not-positive", "Jm", "0"),
    ),
    "gent by other names": ("name: a\nlaw: gent\nconstants: {mu: 0.1, J: 3}\n", ("law-constants-unknown", "mu,Jm")),
    "ogden without a pair": ("name: a\nlaw: ogden\nconstants: {mu1: 0.1}\n", ("law-constants-unknown", "ogden")),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_file_is_refused(case: str, tmp_path: Path) -> None:
    text, says = WRONG[case]
    path = tmp_path / "wrong.yaml"
    path.write_text(text)
    with refused(*says) as caught:
        read_material(path)
    assert "wrong.yaml" in str(caught.value)


def test_a_file_that_is_missing_or_no_text_is_refused(tmp_path: Path) -> None:
    with refused("file-unreadable", "nowhere.yaml"):
        read_material(tmp_path / "nowhere.yaml")
    (tmp_path / "bytes.yaml").write_bytes(b"\xff\xfe\x00\x80")
    with refused("file-not-text", "bytes.yaml"):
        read_material(tmp_path / "bytes.yaml")
    with refused("file-unwritable", "folder.yaml"):
        write_material(tmp_path / "no" / "folder.yaml", get_material("neo-hooke:0.01"))


def test_a_study_takes_a_material_file_relative_to_its_own_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "studies"
    folder.mkdir()
    write_material(folder / "mine.yaml", Material("mine", get_material("gent:0.03,80").law))
    (folder / "study.yaml").write_text("name: mine\nmaterial:\n  name: mine.yaml\n  bulk_ratio: 500\n")
    monkeypatch.chdir(tmp_path)
    material = read_study("studies/study.yaml").material.material()
    assert material.law.constants == {"mu": 0.03, "Jm": 80}
    assert material.bulk_ratio == 500


@pytest.mark.parametrize("name", list_materials())
def test_a_study_takes_any_material_of_the_library(name: str, tmp_path: Path) -> None:
    path = tmp_path / "study.yaml"
    path.write_text(f"name: any\nmaterial:\n  name: {name}\n")
    assert read_study(path).material.material().name == name
    assert MaterialSpec(name=name).material().key_data() == get_material(name).key_data()


def test_a_study_refuses_a_material_file_that_is_wrong_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "study.yaml"
    path.write_text("name: mine\nmaterial:\n  name: nowhere.yaml\n")
    with refused("file-unreadable", "study.yaml:3", "material.name", "nowhere.yaml"):
        read_study(path)


RELAXATION = Relaxation((0.05, 0.1), (0.5, 20.0), Moduli.INSTANTANEOUS)


def test_a_relaxation_is_read_back_and_belongs_to_the_identity(tmp_path: Path) -> None:
    plain = get_material("zaid_2024_ecoflex_00_30")
    material = replace(plain, relaxation=RELAXATION)
    write_material(tmp_path / "mine.yaml", material)
    again = read_material(tmp_path / "mine.yaml")
    assert again.relaxation == RELAXATION
    assert "relaxation" not in plain.key_data()  # keys of materials that do not relax stay as they were
    assert material.key_data() != plain.key_data()
    assert material_from_data({"name": "mine", **again.key_data()}).relaxation == RELAXATION
    assert material_from_data({"name": plain.name, **material.key_data()}).relaxation == RELAXATION
    assert material_from_data({"name": plain.name, **plain.key_data()}).relaxation is None


def test_a_list_of_terms_alone_is_of_long_term_moduli(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(GOOD + "relaxation:\n- {share: 0.1, time: 3}\n")
    assert read_material(path).relaxation == Relaxation((0.1,), (3.0,), Moduli.LONG_TERM)


WRONG_RELAXATION = {
    "a number": ("relaxation: 3\n", ("relaxation-not-list", "relaxation")),
    "no terms": ("relaxation: {moduli: long-term}\n", ("relaxation-not-list", "relaxation")),
    "another key": ("relaxation: {terms: [], tau: 1}\n", ("relaxation-not-list", "relaxation")),
    "no share": ("relaxation: [{time: 1}]\n", ("relaxation-term-malformed", "share", "time")),
    "a term as numbers": ("relaxation: [[0.1, 3]]\n", ("relaxation-term-malformed", "share", "time")),
    "other moduli": (
        "relaxation: {moduli: dynamic, terms: [{share: 0.1, time: 1}]}\n",
        ("moduli-unknown", "relaxation.moduli", "dynamic"),
    ),
    "a text for a time": (
        "relaxation: [{share: 0.1, time: soon}]\n",
        ("value-not-number", "relaxation.terms[1].time", "soon"),
    ),
    "no end": ("relaxation: [{share: 1, time: 1}]\n", ("relaxation-shares-sum", "1")),
    "an empty list": ("relaxation: []\n", ("relaxation-lengths-differ", "0")),
}


@pytest.mark.parametrize("kind", WRONG_RELAXATION)
def test_a_wrong_relaxation_is_refused_with_the_file(kind: str, tmp_path: Path) -> None:
    text, says = WRONG_RELAXATION[kind]
    path = tmp_path / "wrong.yaml"
    path.write_text(GOOD + text)
    with refused(*says) as caught:
        read_material(path)
    assert str(path) in caught.value.problem
    assert caught.value.remedy


def test_a_gel_that_relaxes_otherwise_than_its_wall_has_no_relaxation_of_the_whole() -> None:
    wall = replace(get_material("neo-hooke:0.02"), relaxation=RELAXATION)
    assert replace(wall, gel=wall).whole_relaxation == RELAXATION
    with refused("gel-relaxes-otherwise"):
        _ = replace(wall, gel=get_material("neo-hooke:0.002")).whole_relaxation
