import json
import struct
import tracemalloc
import zlib
from dataclasses import replace
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from errors import check_refusal, check_values
from palpate.camera import CameraSpec, RenderSpec, build_camera, flat_marker_outlines, render
from palpate.cli import main
from palpate.datasets import Normalisation
from palpate.design import DomeSpec, MarkerSpec, build_skin, place_markers, place_orientation_mark
from palpate.fea import WallSpec
from palpate.learn import Estimator, read_estimator, write_estimator
from palpate.learn.force import ForceHead
from palpate.learn.force_graph import add_forces
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin
from palpate.sensor import Flag
from presses import solve_press

DOME = build_skin(DomeSpec())
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
        edges = flat_marker_outlines(points + np.array([0, 0, shift]), normals, LAYOUT.diameter)
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
    assert run("sensor", "detect", str(recording), "--json") == 0
    shown = json.loads(capsys.readouterr().out)["rows"]
    assert [row["dots"] for row in shown] == [38, 38, 38, None]
    assert shown[3]["reason"]
    assert run("sensor", "detect", str(recording)) == 0
    assert "dark" in capsys.readouterr().out


def test_live_reads_a_recording_and_flags_what_is_cut_off(recording, model, tmp_path, capsys):
    words = ["sensor", "live", "--model", str(model), "--source", str(recording), "--markers", "37"]
    assert run(*words, "--json", "--out", str(tmp_path / "readings.csv")) == 0
    shown = json.loads(capsys.readouterr().out)
    assert [row["depth_mm"] for row in shown[:2]] == pytest.approx([1.0, 2.0], abs=0.1)
    assert all(row["touching"] for row in shown[:2])
    assert shown[2]["flags"] == str(Flag.UNREADABLE)
    assert len((tmp_path / "readings.csv").read_text().splitlines()) == 4
    assert run(*words) == 0
    check_values(capsys.readouterr().err, 37)
    assert run(*words, "--refine-lens") == 0
    check_values(capsys.readouterr().err, 37, "px")


def test_live_tells_the_force_that_a_network_knows(recording, model, tmp_path, capsys):
    estimator = read_estimator(model)
    still = replace(
        estimator,
        weights=(np.zeros((1, 74, 3)),),
        biases=(np.zeros((1, 3)),),
        output_mean=np.array([0.03, 0.04, 0.5]),
    )
    head = ForceHead(still, np.full(3, 0.01), np.full(3, 0.02), 0.9, {})
    add_forces(model, head, tmp_path / "f.onnx")
    words = [
        "sensor",
        "live",
        "--model",
        str(tmp_path / "f.onnx"),
        "--source",
        str(recording),
        "--markers",
        "37",
        "--json",
    ]
    assert run(*words) == 0
    row = json.loads(capsys.readouterr().out)[0]
    assert row["depth_mm"] == pytest.approx(1.0, abs=0.1)
    assert row["normal_force_n"] == pytest.approx(0.5, abs=1e-6)
    assert row["tangential_force_n"] == pytest.approx(0.05, abs=1e-6)
    assert 0.02 < row["normal_force_half_width_n"] < 0.05  # the silicone may be 3 % stiffer
    assert row["friction"] is None


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--markers", "91"), ("model-marker-count", 37, 91)),
        (("--markers", "37", "--rest-images", "0"), ("greater_than_equal", "--rest-images", 1)),
        (
            ("--markers", "37", "--out", "readings.txt"),
            ("file-ending-unknown", ".csv", ".jsonl", ".rosbag2"),
        ),
        (
            ("--markers", "37", "--press-pose", "6", "1.5", "4"),
            ("press-pose-incomplete", "--press-image", "--press-pose"),
        ),
    ],
)
def test_live_refuses_what_does_not_fit(recording, model, words, says, capsys):
    assert run("sensor", "live", "--model", str(model), "--source", str(recording), *words) == 2
    check_refusal(capsys.readouterr().err, *says)


@pytest.mark.parametrize("count", ["3", "9"])
def test_live_refuses_to_spend_every_image_on_rest(recording, model, count, capsys):
    (recording / "3.png").unlink()
    words = [
        "sensor",
        "live",
        "--model",
        str(model),
        "--source",
        str(recording),
        "--markers",
        "37",
        "--rest-images",
        count,
    ]
    assert run(*words) == 2
    check_refusal(capsys.readouterr().err, "rest-images-leave-none", count)


def test_live_refuses_a_file_that_is_no_model(recording, capsys):
    (recording / "m.onnx").write_text("no model")
    assert (
        run("sensor", "live", "--model", str(recording / "m.onnx"), "--source", str(recording), "--markers", "37")
        == 2
    )
    check_refusal(capsys.readouterr().err, "model-unreadable", "m.onnx", "palpate calibration predict")


def test_live_reads_a_video_that_is_cut_off_and_flags_the_end(recording, model, tmp_path, capsys):
    path = tmp_path / "v.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 10, (346, 260))
    for name in ("0", "1", "2") + 30 * ("2",):
        writer.write(cv2.imread(str(recording / f"{name}.png")))
    writer.release()
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    words = ["sensor", "live", "--model", str(model), "--source", str(path), "--markers", "37", "--json"]
    assert run(*words) == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown[0]["depth_mm"] == pytest.approx(1.0, abs=0.2)
    assert shown[-1]["flags"] == str(Flag.UNREADABLE)
    assert shown[-1]["reason"]
    assert run(*words, "--count", "2") == 0
    assert len(json.loads(capsys.readouterr().out)) == 2


def test_live_plays_a_simulated_sensor_until_asked_to_stop(model, capsys):
    words = ["sensor", "live", "--model", str(model), "--source", "synthetic", "--markers", "37"]
    assert run(*words, "--rest-images", "3", "--count", "30", "--json") == 0
    shown = json.loads(capsys.readouterr().out)
    assert not shown[2]["touching"]
    assert shown[29]["touching"]


def test_serve_opens_a_simulated_sensor(model, monkeypatch):
    served = []
    monkeypatch.setattr("palpate.viewer.serve_readings", lambda sensor, feed, *_: served.append((sensor, feed)))
    words = ["sensor", "serve", "--model", str(model), "--source", "synthetic", "--markers", "37"]
    assert run(*words, "--rest-images", "3") == 0
    assert served[0][0].assignment.found.sum() == 37


def test_live_prints_no_pose_of_an_untouched_dome(model, capsys):
    words = ["sensor", "live", "--model", str(model), "--source", "synthetic", "--markers", "37"]
    assert run(*words, "--rest-images", "3", "--count", "30") == 0
    lines = [line.split() for line in capsys.readouterr().out.splitlines()]
    cells = [dict(zip(lines[0], line, strict=False)) for line in lines[1:]]
    assert [row["rx_deg"] == "–" for row in cells] == [row["touching"] == "False" for row in cells]
    assert {row["touching"] for row in cells} == {"False", "True"}


def test_live_says_what_to_do_without_a_camera(model, capsys):
    assert run("sensor", "live", "--model", str(model), "--source", "987", "--markers", "37") == 2
    check_refusal(capsys.readouterr().err, "source-not-opened", 987, "synthetic")


def test_live_names_markers_without_a_mark_by_a_known_press(recording, model, capsys):
    camera = build_camera(CameraSpec(roll_deg=65.0))
    normals = (LAYOUT.positions - [0, 0, DOME.center_z]) / DOME.radius
    wall = WallSpec(tilt_deg=8.0, azimuth_deg=15.0, depth=4.0, depth_step=4.0)
    press = solve_press(mesh_skin(DOME, MeshSpec(cells=6)), get_material("zaid_2024_ecoflex_00_30"), wall)
    rest, pressed = press.positions(LAYOUT.positions)[[0, -1]]
    for name, points in (("0", rest), ("1", rest - [0, 0, 1]), ("2", rest - [0, 0, 2]), ("press", pressed)):
        image = render(
            camera, flat_marker_outlines(points, normals, LAYOUT.diameter), RenderSpec(noise=1.0, blur_px=0.6)
        )
        cv2.imwrite(str((recording if name != "press" else recording.parent) / f"{name}.png"), image)
    words = ["sensor", "live", "--model", str(model), "--source", str(recording), "--markers", "37", "--json"]
    assert run(*words) == 2
    check_refusal(capsys.readouterr().err, "orientation-mark-unseen")
    known = ["--press-image", str(recording.parent / "press.png"), "--press-pose", "7.7", "2.1", "4"]
    assert run(*words, *known) == 0
    shown = json.loads(capsys.readouterr().out)
    assert [row["depth_mm"] for row in shown[:2]] == pytest.approx([1.0, 2.0], abs=0.1)
    assert run(*words, *known[:3], "-7.7", "2.1", "0") == 2
    check_refusal(capsys.readouterr().err, "press-depth-not-positive", 0)


def write_huge(path):
    """A PNG whose head says 20 000 × 20 000 px: 400 MB as pixels, if its size were not looked at first."""
    side = 20_000
    rows = zlib.compress(bytes(side + 1))

    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    head = struct.pack(">IIBBBBB", side, side, 8, 0, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", rows) + chunk(b"IEND", b""))


def test_hostile_images_in_a_recording_are_flagged_and_fill_no_memory(recording, model, capsys):
    write_huge(recording / "4.png")
    cv2.imwrite(str(recording / "5.png"), np.zeros((1, 1), np.uint8))
    cv2.imwrite(str(recording / "6.png"), np.zeros((260, 346), np.uint8))
    (recording / "7.png").write_bytes((recording / "1.png").read_bytes())
    words = ["sensor", "live", "--model", str(model), "--source", str(recording), "--markers", "37", "--json"]
    tracemalloc.start()  # knows the arrays of numpy; what Pillow decodes it would not, so the size is looked at first
    try:
        assert run(*words) == 0
        assert tracemalloc.get_traced_memory()[1] < 200e6
    finally:
        tracemalloc.stop()
    shown = json.loads(capsys.readouterr().out)
    assert [bool(row["flags"]) for row in shown] == [False, False, True, True, True, True, False]
    assert "20000 × 20000 px" in shown[3]["reason"]
    assert "1 × 1 px" in shown[4]["reason"]
    assert shown[6]["depth_mm"] == pytest.approx(1.0, abs=0.1)
    assert run("sensor", "detect", str(recording), "--json") == 0
    found = json.loads(capsys.readouterr().out)["rows"]
    assert [row["dots"] for row in found] == [38, 38, 38, None, None, None, None, 38]


def test_a_recording_that_begins_all_black_is_refused(recording, model, capsys):
    cv2.imwrite(str(recording / "0.png"), np.zeros((260, 346), np.uint8))
    words = ["sensor", "live", "--model", str(model), "--source", str(recording), "--markers", "37"]
    assert run(*words) == 2
    check_refusal(capsys.readouterr().err, "markers-not-found", 0)


@pytest.mark.parametrize("design", [("--height", "10"), ("--height", "30"), ("--base-radius", "26")])
def test_a_recording_of_another_design_is_refused(recording, model, design, capsys):
    words = ["sensor", "live", "--model", str(model), "--source", str(recording), "--markers", "37"]
    assert run(*words, *design) == 2
    misfits = ("layout-misfit", "layout-misfit-rings", "layout-misfit-scale")
    unnamed = ("markers-not-assigned", "assignment-doubtful", "orientation-mark-unseen")
    check_refusal(capsys.readouterr().err, (*misfits, *unnamed))


def test_a_camera_that_is_unplugged_mid_run_ends_with_a_flagged_reading(
    recording, model, tmp_path, monkeypatch, capsys
):
    images = [cv2.imread(str(recording / f"{name}.png")) for name in "0122"]
    released = []
    camera = SimpleNamespace(
        isOpened=lambda: True,
        read=lambda: (True, images.pop(0)) if images else (False, None),
        get=lambda what: 346.0 if what == cv2.CAP_PROP_FRAME_WIDTH else 260.0,
        release=lambda: released.append(True),
    )
    monkeypatch.setattr(cv2, "VideoCapture", lambda _: camera)
    words = ["sensor", "live", "--model", str(model), "--source", "0", "--markers", "37", "--json"]
    assert run(*words, "--out", str(tmp_path / "out.csv")) == 0
    shown = json.loads(capsys.readouterr().out)
    assert [row["depth_mm"] is None for row in shown] == [False, False, False, True]
    assert shown[-1]["flags"]
    assert shown[-1]["reason"]
    assert len((tmp_path / "out.csv").read_text().splitlines()) == 5
    assert released


def test_a_model_that_is_missing_or_no_twin_is_refused(tmp_path, capsys):
    truth = tmp_path / "truth.csv"
    truth.write_text("image,press,rx_deg,ry_deg,depth_mm\n0.png,rest,,,\n1.png,1,1,0,3\n")
    (tmp_path / "0.png").write_bytes(b"")
    (tmp_path / "bad.h5").write_text("no twin")
    for name, code in (("none.h5", "file-missing"), ("bad.h5", "twin-unreadable")):
        assert run("calibration", "accept", str(truth), "--model", str(tmp_path / name)) == 2
        said = capsys.readouterr().err
        check_refusal(said, code, name)
        assert "synchronously" not in said
