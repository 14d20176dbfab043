import json

import cv2
import numpy as np
import pytest

from palpate.camera import RenderSpec, build_camera, dot_edges, render
from palpate.cli import main
from palpate.dataset import Normalisation
from palpate.design import DomeSpec, MarkerSpec, build_dome, place_markers, place_orientation_mark
from palpate.learn import Estimator, write_estimator

DOME = build_dome(DomeSpec())
LAYOUT = place_markers(DOME, MarkerSpec(count=37))


def run(*words):
    with pytest.raises(SystemExit) as left:
        main(words)
    return left.value.code


@pytest.fixture
def recording(tmp_path):
    """A folder with the dome at rest, moved up by 1 and 2 mm, and a file that is cut off."""
    points = np.vstack([LAYOUT.positions, place_orientation_mark(DOME, LAYOUT)])
    normals = (points - [0, 0, DOME.center_z]) / DOME.radius
    for number, shift in enumerate((0.0, -1.0, -2.0)):
        edges = dot_edges(points + np.array([0, 0, shift]), normals, LAYOUT.diameter)
        cv2.imwrite(
            str(tmp_path / f"{number}.png"), render(build_camera(), edges, RenderSpec(noise=1.0, blur_px=0.6))
        )
    (tmp_path / "3.png").write_bytes((tmp_path / "2.png").read_bytes()[:60])
    return tmp_path


@pytest.fixture
def model(tmp_path_factory):
    """A linear model of how far the markers spread."""
    rest = build_camera().project(LAYOUT.positions)
    raised = build_camera().project(LAYOUT.positions - [0, 0, 2.0])
    scale = Normalisation((173.0, 130.0), (173.0, 130.0))
    moved = (scale.apply(raised[None]) - scale.apply(rest[None])).reshape(-1)
    weights = np.zeros((1, moved.size, 3))
    weights[0, :, 2] = 2.0 * moved / (moved @ moved)
    bias = -scale.apply(rest[None]).reshape(-1) @ weights[0]
    estimator = Estimator(
        normalisation=scale,
        weights=(weights,),
        biases=(bias[None],),
        activation="relu",
        output_mean=np.zeros(3),
        output_sd=np.ones(3),
        rest_px=rest,
        seed=0,
        made_by={"method": "test"},
        training_images=1,
        validation_images=0,
    )
    path = tmp_path_factory.mktemp("model") / "m.onnx"
    write_estimator(path, estimator)
    return path


def test_find_counts_the_dots_of_every_image(recording, capsys):
    assert run("find", str(recording), "--json") == 0
    said = json.loads(capsys.readouterr().out)
    assert [row["dots"] for row in said] == [38, 38, 38, None]
    assert "cut off" in said[3]["reason"] or "cannot be read" in said[3]["reason"]
    assert run("find", str(recording)) == 0
    assert "dark" in capsys.readouterr().out


def test_live_reads_a_recording_and_flags_what_is_cut_off(recording, model, tmp_path, capsys):
    words = ["live", "--model", str(model), "--source", str(recording), "--markers", "37"]
    assert run(*words, "--json", "--out", str(tmp_path / "readings.csv")) == 0
    said = json.loads(capsys.readouterr().out)
    assert [row["depth_mm"] for row in said[:2]] == pytest.approx([1.0, 2.0], abs=0.1)
    assert all(row["touching"] for row in said[:2])
    assert said[2]["flags"] == "the image could not be read"
    assert len((tmp_path / "readings.csv").read_text().splitlines()) == 4
    assert run(*words) == 0
    assert "37 markers named" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--markers", "91"), "reads 37 markers, the design has 91"),
        (("--markers", "37", "--rest-images", "9"), "leave nothing to read"),
        (("--markers", "37", "--out", "readings.txt"), "neither .csv nor .jsonl"),
    ],
)
def test_live_refuses_what_does_not_fit(recording, model, words, says, capsys):
    assert run("live", "--model", str(model), "--source", str(recording), *words) == 2
    assert says in capsys.readouterr().err


def test_live_refuses_a_file_that_is_no_model(recording, capsys):
    (recording / "m.onnx").write_text("no model")
    assert run("live", "--model", str(recording / "m.onnx"), "--source", str(recording), "--markers", "37") == 2
    assert "is not an estimator" in capsys.readouterr().err
