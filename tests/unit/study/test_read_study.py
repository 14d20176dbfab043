import re
from pathlib import Path

import pytest

from errors import refused
from palpate.core import PalpateError
from palpate.study import Study, list_presets, read_study
from palpate.study.plan import plan_study
from palpate.study.task import PressTask

ROOT = Path(__file__).parents[3]


def write(folder: Path, text: str) -> Path:
    path = folder / "mine.yaml"
    path.write_text(text)
    return path


def refusal(folder: Path, text: str) -> str:
    with pytest.raises(PalpateError) as caught:
        read_study(write(folder, text))
    return str(caught.value).replace(str(folder) + "/", "")


def test_presets_are_named() -> None:
    assert list_presets() == (
        "any_wall",
        "barrel",
        "best",
        "best_frictionless",
        "filled_hemisphere",
        "first",
        "flat_pad",
        "gel_pad",
        "hemisphere_397",
        "paper",
        "paper_h20",
        "small_tactip",
        "tactip_127",
        "tactip_331",
    )


@pytest.mark.parametrize(("name", "contact"), [("best", "no-slip"), ("best_frictionless", "frictionless")])
def test_best_is_the_papers_48_designs_under_either_contact_law(name: str, contact: str) -> None:
    study, paper = read_study(name), read_study("paper")
    assert study.designs == paper.designs
    assert study.tilts_deg == paper.tilts_deg
    assert len(study.designs.skins()) * len(study.designs.markers) == 48
    assert (study.obstacle.contact, study.learning.preset) == (contact, "best")


def test_the_papers_protocol_on_its_height_of_20_mm_shares_the_presses_of_the_whole_grid() -> None:
    study, whole = read_study("paper_h20"), read_study("best")
    assert (study.dataset.poses, study.learning.preset) == ("paper-91", "paper")
    keys = {press.recipe.key for design in plan_study(whole).designs for press in design.dataset.presses}
    assert {press.recipe.key for design in plan_study(study).designs for press in design.dataset.presses} < keys


@pytest.mark.parametrize("name", ["best", "best_frictionless", "first", "paper", "paper_h20"])
def test_the_studies_at_the_root_are_the_presets(name: str) -> None:
    assert read_study(ROOT / "studies" / f"{name}.yaml") == read_study(name)
    inside = ROOT / "src" / "palpate" / "study" / "presets" / f"{name}.yaml"
    assert (ROOT / "studies" / f"{name}.yaml").read_text() == inside.read_text()


def test_first_is_eight_designs_of_fourteen_presses() -> None:
    study = read_study("first")
    assert [(dome.height, dome.thickness) for dome in study.designs.skins()] == [(20, 2), (20, 3)]
    assert [layout.count for layout in study.designs.markers] == [7, 37, 91, 169]
    assert study.tilts_deg == (0, 2, 4, 6, 8, 10, 12)
    assert (study.obstacle.contact, study.obstacle.depth, study.obstacle.depth_step) == ("no-slip", 8, 0.8)


def test_paper_is_its_whole_grid() -> None:
    designs = read_study("paper").designs
    assert len(designs.skins()) * len(designs.markers) == 48


def test_a_number_may_carry_its_unit(tmp_path: Path) -> None:
    study = read_study(write(tmp_path, "name: a\ndesigns:\n  heights: [10 mm, 20]\nobstacle: {depth: 4 mm}\n"))
    assert study.designs.heights == (10, 20)
    assert study.obstacle.depth == 4


def test_files_are_taken_relative_to_the_study(tmp_path: Path) -> None:
    study = read_study(write(tmp_path, "name: a\ndesigns: {markers: [7, {file: dots.csv}]}\n"))
    assert study.designs.markers[1].file == tmp_path / "dots.csv"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("name: a\ndesigns:\n  hights: [20]\n", ("extra_forbidden", "mine.yaml:3", "designs.hights", "heights")),
        ("name: a\nobstacl: 3\n", ("extra_forbidden", "mine.yaml:2: obstacl", "obstacle?")),
        ("name: a\nxyzzy: 3\n", ("extra_forbidden", "mine.yaml:2: xyzzy", "name, seed,")),
        ("name: a\nobstacle: {depth: 4 cm}\n", ("quantity-unit-wrong", "mine.yaml:2: obstacle.depth", "cm", "mm")),
        ("name: a\n\nobstacle:\n  depth: 100\n", ("less_than_equal", "mine.yaml:4: obstacle.depth", "60 mm", 100)),
        ("name: a\ndesigns:\n  heights:\n    - 70\n", ("less_than_equal", "mine.yaml:3: designs.heights", 70)),
        ("name: a\ndesigns:\n  markers: [7, 8]\n", ("marker-count-not-rings", "mine.yaml:3: designs.markers.1", 8)),
        ("name: a\ntilts_deg: [0, 40]\n", ("less_than_equal", "mine.yaml:2: tilts_deg", 40, 30)),
        ("name: a\ntilts_deg: [4, 2]\n", ("positions-not-ascending", "mine.yaml:2: tilts_deg")),
        ("name: a\ntilts_deg: []\n", ("list-empty", "mine.yaml:2: tilts_deg")),
        ("name: a\nbuilt: {contacts: []}\n", ("twin-contacts", "mine.yaml:2: built.contacts", "no-slip")),
        ("name: a\nbuilt: {contacts: [no-slip, 0]}\n", ("twin-contacts", "mine.yaml:2", "frictionless")),
        ("name: a\nobstacle: {tilt_deg: 3}\n", ("obstacle-position-given", "mine.yaml:2: obstacle", "tilt_deg")),
        ("name: a\nmaterial: {name: ecoflex}\n", ("material-unknown", "mine.yaml:2: material.name", "ecoflex")),
        ("seed: 1\n", ("missing", "mine.yaml:1", "name")),
        ("name: a\nseed: [1\n", ("yaml-malformed", "mine.yaml:3")),
        ("name: a\nname: b\n", ("yaml-malformed", "mine.yaml:2")),
        ("- a\n", ("yaml-not-mapping", "mine.yaml:1")),
        ("a: " + "[" * 1000, ("yaml-too-deep", "mine.yaml")),
        ('name: a\ndesigns: {markers: [{file: "a\\0b"}]}\n', ("file-name-malformed",)),
        ('name: a\nmaterial: {name: "a\\0.yaml"}\n', ("file-name-malformed",)),
        ("", ("yaml-not-mapping", "mine.yaml:1")),
        ("name: ../up\n", ("string_pattern_mismatch", "mine.yaml:1: name", "../up")),
    ],
)
def test_a_bad_study_is_an_error_with_its_place(tmp_path: Path, text: str, says: tuple[str, ...]) -> None:
    with refused(*says):
        read_study(write(tmp_path, text))


def test_several_errors_come_together_in_the_order_of_the_file(tmp_path: Path) -> None:
    lines = refusal(tmp_path, "name: a\nseed: -1\nwal: 3\ntilts_deg: [99]\n").splitlines()
    assert [line.split(":")[1] for line in lines] == ["2", "3", "4"]


def test_more_errors_than_a_screen_holds_are_counted(tmp_path: Path) -> None:
    keys = "".join(f"key{i}: 1\n" for i in range(12))
    assert refusal(tmp_path, "name: a\n" + keys).splitlines()[-1].count("4") == 1


def test_a_number_of_presses_in_the_comment_of_a_preset_is_that_of_its_plan() -> None:
    files = {name: ROOT / "src" / "palpate" / "study" / "presets" / f"{name}.yaml" for name in list_presets()}
    stated = {name: re.findall(r"\b(\d+) presses", file.read_text("utf-8")) for name, file in files.items()}
    assert stated["first"] == ["22"]
    for name, numbers in stated.items():
        tasks = plan_study(read_study(name)).tasks() if numbers else ()
        assert set(numbers) <= {str(sum(isinstance(task, PressTask) for task in tasks))}, name


def test_an_unknown_name_lists_the_presets() -> None:
    with refused("file-unreadable", "second", "first, flat_pad"):
        read_study("second")


def test_a_file_that_is_no_text_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "mine.yaml").write_bytes(b"\xff\xfe\x00\x80")
    with refused("file-not-text"):
        read_study(tmp_path / "mine.yaml")


def test_seeds_come_from_the_study_unless_given() -> None:
    drawn = Study(name="a", seed=5).seeded()
    assert drawn.dataset.seed != drawn.learning.seed
    assert drawn == Study(name="a", seed=5).seeded() != Study(name="a", seed=6).seeded()
    given = Study.model_validate({"name": "a", "seed": 5, "dataset": {"seed": 3}}).seeded()
    assert given.dataset.seed == 3


@pytest.mark.parametrize(
    ("choice", "says"),
    [
        ({"tilts_deg": (2.0, 2.0)}, ("positions-not-ascending", "tilts_deg")),
        ({"azimuths_deg": (0.0,)}, ("azimuths-uneven",)),
        ({"azimuths_deg": (0.0, 40.0, 90.0)}, ("azimuths-uneven",)),
        ({"azimuths_deg": (0.0, 40.0, 80.0)}, ("azimuths-uneven",)),
        ({"obstacle": {"kind": "route"}}, ("obstacle-without-position", "route")),
        ({"obstacle": {"kind": "ball"}}, ("positions-of-another-obstacle", "offsets_mm")),
        ({"obstacle": {"kind": "ball"}, "offsets_mm": (0.0, 0.0)}, ("positions-not-ascending", "offsets_mm")),
        ({"offsets_mm": (0.0, 1.0)}, ("positions-of-another-obstacle", "tilts_deg")),
        ({"obstacle": {"kind": "ball"}, "offsets_mm": (0.0, 1.0), "forces": True}, ("key-needs-wall", "forces")),
    ],
)
def test_positions_that_do_not_fit_each_other_or_the_obstacle_are_refused(
    choice: dict[str, object], says: tuple[str, ...]
) -> None:
    with refused(*says):
        Study.model_validate({"name": "a", **choice})


@pytest.mark.parametrize(
    "choice",
    [
        {"tilts_deg": (0.0, 0.1, 30.0)},
        {"azimuths_deg": (0.0, 90.0)},
        {"azimuths_deg": (0.0, 22.5, 45.0, 67.5, 90.0)},
        {"obstacle": {"kind": "ball"}, "offsets_mm": (0.0, 1.0)},
    ],
)
def test_positions_that_fit_are_kept_and_written(choice: dict[str, object]) -> None:
    written = Study.model_validate({"name": "a", **choice}).model_dump()
    assert {name: written.get(name) for name in choice if name != "obstacle"} == {
        name: value for name, value in choice.items() if name != "obstacle"
    }
    assert {"azimuths_deg", "offsets_mm"} & written.keys() == {"azimuths_deg", "offsets_mm"} & choice.keys()
