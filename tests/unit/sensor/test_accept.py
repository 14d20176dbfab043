"""Whether a unit passes, from recorded presses."""

import csv
import json
import shutil
from dataclasses import replace

import cv2
import numpy as np
import pytest

from errors import check_refusal, refused
from palpate.calibration import Deviation
from palpate.cli import main
from palpate.core import generator
from palpate.sensor import (
    AcceptanceSpec,
    Certificate,
    GroundTruth,
    ReferenceSpec,
    accept_unit,
    read_ground_truth,
    read_readings,
)
from palpate.sensor.accept import _rmse_limit
from palpate.simulation.run_trial import solve_unit_presses
from palpate.simulation.simulated_unit import SimulatedUnit
from small_chain import small_bench, write_small_model

COLUMNS = ("image", "press", "rx_deg", "ry_deg", "depth_mm")


def recorded(presses=8, error=0.2, offset=0.7):
    depth = np.arange(0.8, 8.1, 0.8)
    rng = generator(0, "accept")
    angles = rng.uniform(-8, 8, (presses, 2))
    poses = np.array([[*angles[k], value + offset] for k in range(presses) for value in depth])
    press = np.repeat(np.arange(presses), len(depth))
    noise = np.column_stack([error * rng.normal(size=(len(poses), 2)), 0.02 * rng.normal(size=len(poses))])
    estimates = poses - np.array([0.0, 0.0, offset]) + noise
    truth = GroundTruth(
        ("r",), tuple(str(k + 1) for k in range(len(poses))), press, poses, np.full(len(poses), np.nan)
    )
    return truth, estimates


def test_a_good_unit_passes_and_a_bad_one_says_what_failed():
    truth, good = recorded()
    found = accept_unit(truth, good)
    assert found.passed
    assert found.zero.offset == pytest.approx(0.7, abs=0.03)
    assert len(found.truth) == 7 * 8
    assert found.left_out == 10 + 7 * 2
    bad = accept_unit(*recorded(error=0.9))
    assert not bad.passed
    assert next(check.what for check in bad.checks if not check.passed) == "roll RMSE"


def test_where_doubt_must_not_pass_the_interval_is_judged():
    truth, estimates = recorded(error=0.5)
    limit = AcceptanceSpec(max_deg=5.0)
    guarded = accept_unit(truth, estimates, None, limit)
    assert not guarded.passed
    assert {check.decision for check in guarded.checks if not check.passed} == {"not decided"}
    simple = accept_unit(truth, estimates, None, limit.model_copy(update={"guard": False}))
    assert simple.passed
    assert {check.decision for check in simple.checks} == {"within tolerance", "accepted (simple)"}


def errors_of(rng, presses, between, within, images=4):
    press = np.repeat(np.arange(presses), images)
    return between * rng.standard_normal(presses)[press] + within * rng.standard_normal(len(press)), press


@pytest.mark.parametrize("presses", [5, 10, 18])
@pytest.mark.parametrize(("between", "within"), [(1.0, 0.0), (1.0, 0.3), (0.7, 0.7), (0.3, 1.0)])
def test_a_unit_at_its_tolerance_is_rarely_proven(presses, between, within):
    """The true RMSE is above the upper limit in 5 % of 400 tests or less; the percentile bootstrap has up to 20 %."""
    rng, true = generator(0, "limit"), np.hypot(between, within)
    found = [_rmse_limit(*errors_of(rng, presses, between, within)) for _ in range(400)]
    assert np.mean(np.array(found) <= true) <= 0.05
    assert np.median(found) < 3.0 * true


def test_an_rmse_of_few_presses_is_not_decided():
    truth, estimates = recorded(presses=5, error=0.01)
    checks = accept_unit(truth, estimates).checks  # the first press gives the zero
    assert all((check.decision == "not decided") == ("RMSE" in check.what) for check in checks)
    assert accept_unit(*recorded(presses=6, error=0.01)).passed


def test_without_a_zero_the_robots_touch_point_is_in_the_depth():
    truth, estimates = recorded()
    found = accept_unit(truth, estimates, None, AcceptanceSpec(zero=False))
    assert found.scores[2].errors.bias == pytest.approx(-0.7, abs=0.02)
    assert [check.what for check in found.checks if not check.passed] == ["depth RMSE"]


def test_a_first_press_without_a_zero_is_refused_with_the_flag_that_takes_the_depths_as_they_are():
    truth, estimates = recorded()
    with refused("depth-zero-unknown", "--no-zero"):
        accept_unit(truth, estimates, None, AcceptanceSpec(min_depth=9.0))


def test_an_unknown_depth_is_not_judged():
    truth, estimates = recorded()
    poses = truth.poses.copy()
    poses[:, 2] = np.nan
    found = accept_unit(replace(truth, poses=poses), estimates)
    assert [score.component for score in found.scores] == ["roll", "pitch", "total angle"]
    assert found.passed
    assert found.zero is None


def test_images_without_a_pose_count_against_the_unit():
    truth, estimates = recorded()
    estimates[25] = np.nan
    found = accept_unit(truth, estimates)
    assert [check.what for check in found.checks if not check.passed] == ["images without a pose"]
    assert accept_unit(truth, estimates, None, AcceptanceSpec(without_pose=0.05)).passed


def test_too_few_or_too_shallow_presses_are_refused():
    truth, estimates = recorded(presses=1)
    with refused("acceptance-no-press"):
        accept_unit(truth, estimates)


def test_the_report_can_be_printed(tmp_path):
    Certificate(accept_unit(*recorded()), "unit 7").write(tmp_path / "a")
    assert (tmp_path / "a" / "accept.pdf").read_bytes()[:5] == b"%PDF-"
    page = (tmp_path / "a" / "accept.md").read_text()
    assert "# Certificate: unit 7" in page
    assert "**passed; reference standard not stated**" in page
    assert "0.58 / 0.49 / 1.62 / 0.54" in page
    assert json.loads((tmp_path / "a" / "accept.json").read_text())["passed"] is True


def write_truth(path, rows, columns=COLUMNS):
    with path.open("w", newline="") as file:
        csv.writer(file).writerows([columns, *rows])
    return path


@pytest.mark.parametrize(
    ("rows", "columns", "says"),
    [
        ([["a.png", "1", "x", "0", "1"]], COLUMNS, ("value-not-number", "line 2", "rx_deg", "x")),
        ([["a.png", "1", "", "0", "1"]], COLUMNS, ("angle-missing", "line 2")),
        ([["a.png", "1"]], COLUMNS[:2], ("column-missing", "rx, ry, depth")),
        ([["a.png", "rest", "", "", ""]], COLUMNS, ("recording-no-press",)),
    ],
)
def test_a_table_that_is_no_truth_is_refused_with_its_line(tmp_path, rows, columns, says):
    with refused(*says):
        read_ground_truth(write_truth(tmp_path / "t.csv", rows, columns))


def test_a_truth_that_is_not_there_or_no_text_is_refused(tmp_path):
    with refused("file-unreadable", "none.csv"):
        read_ground_truth(tmp_path / "none.csv")
    (tmp_path / "b.csv").write_bytes(b"\xff\xfe\x00" * 40)
    with refused("table-no-numbers", "b.csv"):
        read_ground_truth(tmp_path / "b.csv")


def test_every_image_needs_a_reading(tmp_path):
    truth = read_ground_truth(write_truth(tmp_path / "t.csv", [["1", "1", 1, 2, 3], ["2", "1", 1, 2, ""]]))
    (tmp_path / "r.jsonl").write_text('{"image": 1, "rx_deg": 1.0, "ry_deg": 2.0, "depth_mm": null, "flags": "x"}\n')
    with refused("readings-missing", "1"):
        read_readings(tmp_path / "r.jsonl", truth)
    only = read_ground_truth(write_truth(tmp_path / "t.csv", [["1", "1", 1, 2, 3]]))
    poses, flagged = read_readings(tmp_path / "r.jsonl", only)
    assert poses[0, :2].tolist() == [1.0, 2.0]
    assert np.isnan(poses[0, 2])
    assert flagged.tolist() == [True]


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """Images of a small virtual unit with their truth, and its model."""
    folder = tmp_path_factory.mktemp("recording")
    bench = small_bench(folder / "bench", write_small_model(folder / "m.onnx"))
    scene = SimulatedUnit(bench.design, Deviation(), bench.spec.render)
    rows = [["rest.png", "rest", "", "", ""]]
    cv2.imwrite(str(folder / "rest.png"), scene.render_rest())
    for press in solve_unit_presses(bench, Deviation()):
        for turn in (30.0, 110.0, 200.0, 300.0):
            turned = replace(press, obstacle=press.obstacle.model_copy(update={"azimuth_deg": turn}))
            for depth, image in zip(press.depth, scene.render_press(turned), strict=True):
                cv2.imwrite(str(folder / f"{len(rows)}.png"), image)
                angle = np.radians(turn)
                pose = press.obstacle.tilt_deg * np.array([np.cos(angle), np.sin(angle)])
                rows.append([f"{len(rows)}.png", f"{press.obstacle.tilt_deg} {turn}", *pose, depth + 1.0])
    write_truth(folder / "truth.csv", rows)
    return folder


def run(*words):
    with pytest.raises(SystemExit) as left:
        main([str(word) for word in words])
    return left.value.code


def test_a_folder_of_images_is_judged_by_command(recording, tmp_path, capsys):
    words = ["calibration", "accept", recording / "truth.csv", "--model", recording / "m.onnx", "--markers", "37"]
    words += ["--min-depth", "2", "--depth-rmse", "0.3"]
    assert run(*words, "--out", tmp_path / "r", "--name", "U1", "--json") == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["passed"]
    assert shown["zero_mm"] == pytest.approx(1.0, abs=0.2)
    assert (tmp_path / "r" / "accept.pdf").exists()
    assert run(*words, "--rmse", "0.01") == 1
    assert "OUTSIDE TOLERANCE" in capsys.readouterr().out
    assert run(*words, "--rmse", "0.01", "--reference", "plate 7") == 1
    assert "NON-CONFORMITY PROVEN" in capsys.readouterr().out
    assert run(*words, "--name", " ") == 2
    check_refusal(capsys.readouterr().err, "name-empty")


def test_a_unit_needs_a_model_or_readings_and_a_rest_image(recording, tmp_path, capsys):
    words = ["--model", recording / "m.onnx", "--readings", tmp_path / "r.csv"]
    assert run("calibration", "accept", recording / "truth.csv", *words) == 2
    check_refusal(capsys.readouterr().err, "options-exclusive", "--model", "--readings")
    write_truth(tmp_path / "t.csv", [["1.png", "1", 1, 2, 3]])
    shutil.copy(next((recording).glob("*.png")), tmp_path / "1.png")
    assert run("calibration", "accept", tmp_path / "t.csv", "--model", recording / "m.onnx", "--markers", "37") == 2
    check_refusal(capsys.readouterr().err, "rest-image-missing")


def test_a_reference_of_spaces_is_not_stated() -> None:
    assert ReferenceSpec(reference="  ").reference == ""
    assert ReferenceSpec(reference=" plate 7 ").reference == "plate 7"
