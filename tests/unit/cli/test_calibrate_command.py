import json
from pathlib import Path

import pytest

from errors import check_refusal
from palpate.cli import main

PHOTOS = Path(__file__).parents[1] / "camera" / "data" / "chessboard_opencv"


def run(*words):
    with pytest.raises(SystemExit) as left:
        main(["calibration", "camera", *words])
    return left.value.code


def test_a_folder_of_photos_gives_the_lens_as_json_and_file(tmp_path, capsys):
    assert run(str(PHOTOS), "--board", "chessboard:9x6:25", "--out", str(tmp_path / "lens.yaml"), "--json") == 0
    output = json.loads(capsys.readouterr().out)
    assert output["rms_px"] < 0.2
    assert len(output["images"]) == 13
    assert (tmp_path / "lens.yaml").read_text().startswith("%YAML:1.0")


def test_the_table_names_lens_and_images(capsys):
    assert run(str(PHOTOS), "--board", "chessboard:9x6:25") == 0
    shown = capsys.readouterr().out
    assert "left01.jpg" in shown
    assert "fx px" in shown


def test_a_board_is_printed_without_images(tmp_path):
    assert run("--board", "charuco", "--print-board", str(tmp_path / "board.pdf")) == 0
    assert (tmp_path / "board.pdf").exists()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ((), ("argument-missing", "--print-board")),
        (("nowhere",), ("folder-missing", "nowhere")),
        ((str(PHOTOS), "--board", "cheese"), ("board-unknown", "cheese")),
        ((str(PHOTOS), "--board", "charuco"), ("calibration-few-images", 0, 13, 4)),
    ],
)
def test_bad_input_is_reported_in_one_sentence(words, says, capsys):
    assert run(*words) == 2
    check_refusal(capsys.readouterr().err, *says)
