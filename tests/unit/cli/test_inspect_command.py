import csv
import json

import cv2
import numpy as np
import pytest

from errors import check_refusal, check_values
from palpate.camera import RenderSpec, build_camera, flat_marker_outlines, render
from palpate.cli import main
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers, place_orientation_mark

DOME = build_skin(DomeSpec())
LAYOUT = place_markers(DOME, MarkerSpec(count=37))


def run(*words):
    with pytest.raises(SystemExit) as left:
        main(words)
    return left.value.code


@pytest.fixture
def image(tmp_path):
    """The dome at rest, without the dot of marker 20."""
    points = np.delete(np.vstack([LAYOUT.positions, place_orientation_mark(DOME, LAYOUT)]), 20, axis=0)
    edges = flat_marker_outlines(points, (points - [0, 0, DOME.center_z]) / DOME.radius, LAYOUT.diameter)
    path = tmp_path / "rest.png"
    cv2.imwrite(str(path), render(build_camera(), edges, RenderSpec(noise=1.0, blur_px=0.6)))
    return path


def test_inspect_names_the_missing_dot_and_leaves_table_and_picture(image, tmp_path, capsys):
    table, picture = tmp_path / "errors.csv", tmp_path / "errors.svg"
    words = ["calibration", "inspect", str(image), "--markers", "37", "--out", str(table), "--picture", str(picture)]
    assert run(*words, "--json") == 1
    shown = json.loads(capsys.readouterr().out)
    assert not shown["passed"]
    verdicts = {row["marker"]: row["verdict"] for row in shown["markers"]}
    assert [number for number, verdict in verdicts.items() if verdict != "within"] == [20]
    with table.open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 37
    assert rows[20]["distance_mm"] == ""
    assert float(rows[5]["distance_mm"]) < 0.05
    assert picture.read_text().count("<path") > 37
    assert run(*words) == 1
    distance = np.array([row["distance_mm"] for row in shown["markers"] if row["distance_mm"] is not None])
    assert len(distance) == 36
    rms = np.sqrt(np.mean(distance**2))
    check_values(capsys.readouterr().out, 36, 37, f"{rms:.3f} mm", f"{distance.max():.3f} mm")


@pytest.mark.parametrize(
    ("words", "shown"),
    [
        (["nothing.png"], ("image-unreadable", "nothing.png")),
        (["IMAGE", "--markers", "169"], ("assignment-doubtful", 169)),
        (["IMAGE", "--tolerance", "-1"], ("greater_than", "--tolerance", -1)),
        (["IMAGE", "--out", "errors.txt"], ("file-ending-unknown", "errors.txt", ".csv")),
        (["IMAGE", "--picture", "errors.gif"], ("file-ending-unknown", "errors.gif", ".png")),
        (["IMAGE", "--markers", "37", "--out", "no/such/folder/errors.csv"], ("file-unwritable", "errors.csv")),
    ],
)
def test_inspect_refuses_what_cannot_be_inspected(words, shown, image, capsys):
    assert run("calibration", "inspect", *(str(image) if word == "IMAGE" else word for word in words)) == 2
    check_refusal(capsys.readouterr().err, *shown)
