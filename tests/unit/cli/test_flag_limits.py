"""Flags at their limits, from both sides, and what needs two flags or none."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from errors import check_refusal, refused
from palpate.cli import main
from palpate.cli.bench import read_tolerance
from palpate.cli.learn import TableFlags
from palpate.cli.optimise import SearchFlags
from palpate.cli.output import check_file, check_folder
from palpate.cli.sensor import LiveFlags, _at_rest, _known_press, _live_recorded
from palpate.core import PalpateError
from palpate.optimise import RequirementsSpec

BROKEN = PalpateError("The file 7 is damaged.", "Copy it again.", code="image-unreadable")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ("limit first --workers 1025", ("option-out-of-bounds", "--workers", 1025)),
        ("run first --workers 1025", ("option-out-of-bounds", "--workers", 1025)),
        ("run first --timeout 0.9", ("option-out-of-bounds", "--timeout", 0.9)),
        ("sensor live --source synthetic --count 0", ("option-out-of-bounds", "--count", 0)),
        ("press --solver calculix --branch inverted", ("option-not-for-solver", "--branch", "inverted", "calculix")),
        ("press --solver calculix --tolerance 1e-6", ("option-not-for-solver", "--tolerance", "calculix")),
        ("recording train nowhere --out o --times ms", ("forces-missing", "ms", "--forces")),
    ],
)
def test_a_flag_beyond_its_limit_or_without_its_fellow_is_refused(
    words: str, says: tuple[object, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as left:
        main(words.split())
    assert left.value.code == 2
    check_refusal(capsys.readouterr().err, *says)


@pytest.mark.parametrize(("name", "least"), [("skins", 1), ("random_skins", 0)])
def test_numbers_of_skins_end_at_a_hundred_thousand(name: str, least: int) -> None:
    for good in (least, 100_000):
        assert getattr(SearchFlags(**{name: good}).change(RequirementsSpec()), name) == good
    for bad in (least - 1, 100_001):
        with refused("option-out-of-bounds", f"--{name.replace('_', '-')}", bad):
            SearchFlags(**{name: bad}).change(RequirementsSpec())
    assert SearchFlags().change(RequirementsSpec()) == RequirementsSpec()
    assert SearchFlags(validate="none").change(RequirementsSpec()).validation == "none"


def test_flags_of_a_search_are_written_as_they_are_given() -> None:
    flags = SearchFlags(3, "random", 4, "trained", packs=True)
    words = ["--skins", "3", "--sampler", "random", "--random-skins", "4", "--validate", "trained", "--packs"]
    assert flags.words() == words
    assert SearchFlags().words() == []


def test_tolerances_are_pairs_of_a_known_name_and_a_value_within_bounds() -> None:
    found = read_tolerance(("thickness=0.5", "seating_tilt_deg=5"))
    assert (found.thickness, found.seating_tilt_deg) == (0.5, 5.0)
    for text in ("thickness", "thick=1"):
        with refused("tolerance-unknown", text):
            read_tolerance((text,))
    for text in ("seating_tilt_deg=5.1", "thickness=-0.1", "thickness=x"):
        with refused("tolerance-out-of-bounds"):
            read_tolerance((text,))


def test_units_of_forces_need_their_table() -> None:
    mapping = TableFlags(forces=Path("f.csv"), times="ms", force_unit="gf", pose="/pose").mapping()
    assert (mapping.forces, mapping.times, mapping.force_unit, mapping.pose) == (Path("f.csv"), "ms", "gf", "/pose")
    with refused("forces-missing", "gf"):
        TableFlags(force_unit="gf").mapping()


def test_an_output_file_has_its_ending_and_a_folder_that_is_there(tmp_path: Path) -> None:
    check_file(None, ".csv")
    check_file(tmp_path / "a.CSV", ".csv")
    with refused("file-ending-unknown", "a.txt", ".csv"):
        check_file(tmp_path / "a.txt", ".csv", ".json")
    (tmp_path / "b.csv").mkdir()
    with refused("file-is-folder", "b.csv"):
        check_file(tmp_path / "b.csv", ".csv")
    with refused("file-unwritable", "none"):
        check_file(tmp_path / "none" / "a.csv", ".csv")


def test_an_output_folder_may_be_new_but_not_below_a_file(tmp_path: Path) -> None:
    check_folder(None)
    check_folder(tmp_path / "new" / "deeper")
    (tmp_path / "file").write_text("")
    for path in (tmp_path / "file", tmp_path / "file" / "deeper"):
        with refused("folder-unwritable", "file"):
            check_folder(path)


def test_a_reference_press_needs_its_image_and_its_pose() -> None:
    assert _known_press(LiveFlags(), SimpleNamespace()) is None  # type: ignore[arg-type]
    for flags in (LiveFlags(press_image=Path("p.png")), LiveFlags(press_pose=(1.0, 2.0, 3.0))):
        with refused("press-pose-incomplete"):
            _known_press(flags, SimpleNamespace())  # type: ignore[arg-type]


def test_rest_images_are_the_first_ones_and_all_of_them_are_read() -> None:
    images = [np.full((2, 2), level) for level in range(3)]
    assert [int(image[0, 0]) for image in _at_rest(iter(images), 2)] == [0, 1]
    assert len(_at_rest(iter(images), 3)) == 3
    with refused("rest-images-leave-none", 3, 4):
        _at_rest(iter(images), 4)
    with refused("image-unreadable", 7):
        _at_rest(iter([images[0], BROKEN, images[2]]), 3)


def test_a_model_of_a_recording_has_no_simulated_source() -> None:
    with refused("model-no-design"):
        _live_recorded(SimpleNamespace(), "synthetic", None, LiveFlags(), json=False)  # type: ignore[arg-type]
