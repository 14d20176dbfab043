from pathlib import Path

import cv2
import numpy as np
import pytest
from synthetic_board import LENS, MATRIX, SIZE, views

from errors import check_values, refused
from palpate.camera import (
    BoardSpec,
    CalibrationSpec,
    CameraSpec,
    build_camera,
    calibrate_camera,
    list_images,
    read_board,
    read_calibration,
    read_image,
    write_board,
    write_calibration,
)
from palpate.camera.board import BOARDS, board_points
from palpate.camera.find_board import find_board
from palpate.core import generator

PHOTOS = Path(__file__).parent / "data" / "chessboard_opencv"
TRUE = np.array([MATRIX[0, 0], MATRIX[1, 1], MATRIX[0, 2], MATRIX[1, 2]])


def photos():
    return [(path.name, read_image(path)) for path in list_images(PHOTOS)]


def test_the_sample_photos_give_the_published_result():
    spec = CalibrationSpec(board=BOARDS["chessboard"], window_px=11, keep_outliers=True)
    found = calibrate_camera(photos(), spec)
    assert found.rms_px == pytest.approx(0.40869477, abs=0.001)
    np.testing.assert_allclose(found.intrinsics_px, [536.07345, 536.01636, 342.37047, 235.53687], atol=0.2)
    assert len(found.image_names) == 13
    assert found.covariance.shape == (9, 9)


def test_a_window_that_fits_the_squares_fits_the_photos_better():
    assert calibrate_camera(photos(), CalibrationSpec(board=BOARDS["chessboard"])).rms_px < 0.2


@pytest.mark.parametrize("name", BOARDS)
def test_a_known_camera_is_found_from_eight_views_of_every_board(name):
    found = calibrate_camera(views(BOARDS[name], 8), CalibrationSpec(board=BOARDS[name]))
    assert len(found.image_names) == 8
    np.testing.assert_allclose(found.intrinsics_px[:2], TRUE[:2], rtol=0.002)
    np.testing.assert_allclose(found.intrinsics_px[2:], TRUE[2:], atol=0.5)
    assert found.covered > 0.4
    assert found.camera_spec().fx_px == found.intrinsics_px[0]


def test_the_covariance_is_that_of_repeated_calibrations():
    board = BOARDS["chessboard"]
    points = board_points(board)
    rng = generator(0, "repeat")
    poses = [
        (rng.uniform(-0.5, 0.5, 3), np.array([*rng.uniform(-120, 20, 2), rng.uniform(350, 500)])) for _ in range(12)
    ]
    clean = [cv2.projectPoints(points, *pose, MATRIX, LENS)[0].reshape(-1, 2) for pose in poses]
    found = []
    for _ in range(80):
        seen = [(np.arange(len(points)), pixels + rng.normal(0, 0.3, pixels.shape)) for pixels in clean]
        found.append(_calibrate_points(seen, board))
    spread = np.std([lens.intrinsics_px for lens in found], axis=0, ddof=1)
    stated = np.mean([lens.sd[:4] for lens in found], axis=0)
    np.testing.assert_allclose(stated, spread, rtol=0.3)
    assert np.mean([lens.rms_px for lens in found]) == pytest.approx(
        0.3 * np.sqrt(2) * np.sqrt(1 - (8 + 72) / (2 * 54 * 12)), rel=0.02
    )


def _calibrate_points(seen, board):
    import palpate.camera.calibrate as stage

    pending = iter(seen)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stage, "find_board", lambda *_: next(pending))
        blank = np.zeros((SIZE[1], SIZE[0]), np.uint8)
        return calibrate_camera(
            [(str(k), blank) for k in range(len(seen))], CalibrationSpec(board=board, fix_k3=True)
        )


def test_a_fisheye_is_found_used_by_the_camera_and_cannot_pass_for_a_pinhole(tmp_path):
    board = BOARDS["chessboard"]
    points, rng = board_points(board), generator(1, "fisheye")
    lens = np.array([-0.048, 0.011, -0.055, 0.021])
    seen = []
    for _ in range(14):
        turn, shift = rng.uniform(-0.5, 0.5, 3), np.array([*rng.uniform(-160, 0, 2), rng.uniform(220, 320)])
        pixels, _ = cv2.fisheye.projectPoints(points[None], turn, shift, MATRIX, lens)
        seen.append((np.arange(len(points)), pixels.reshape(-1, 2) + rng.normal(0, 0.05, (len(points), 2))))
    import palpate.camera.calibrate as stage

    pending = iter(seen)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(stage, "find_board", lambda *_: next(pending))
        blank = np.zeros((SIZE[1], SIZE[0]), np.uint8)
        found = calibrate_camera([(str(k), blank) for k in range(14)], CalibrationSpec(board=board, lens="fisheye"))
    assert found.model == "equidistant"
    np.testing.assert_allclose(found.intrinsics_px, TRUE, rtol=0.005)
    write_calibration(tmp_path / "fisheye.yaml", found)
    spec = read_calibration(tmp_path / "fisheye.yaml").camera_spec(CameraSpec(distance=30.0))
    assert spec == found.camera_spec(CameraSpec(distance=30.0))
    assert spec.lens == "kannala-brandt"
    domed = rng.uniform([-20, -20, 1], [20, 20, 25], (200, 3))
    fx, fy, cx, cy = found.intrinsics_px
    matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])
    expected, _ = cv2.fisheye.projectPoints(
        domed[None], np.zeros(3), np.array([0, 0, 30.0]), matrix, found.distortion
    )
    np.testing.assert_allclose(build_camera(spec).project(domed), expected[0], atol=1e-3)
    text = (tmp_path / "fisheye.yaml").read_text().replace('distortion_model: "equidistant"', "")
    (tmp_path / "mixed.yaml").write_text(text)
    with refused("lens-model-ambiguous", "4"):
        read_calibration(tmp_path / "mixed.yaml")


def test_images_that_cannot_be_used_are_named_with_the_reason():
    board = BOARDS["chessboard"]
    good = photos()
    bad = [
        ("empty", np.zeros((480, 640), np.uint8)),
        ("unread", "it is cut off"),
        ("small", cv2.resize(good[0][1], (320, 240))),
        ("dot", np.zeros((1, 1), np.uint8)),
    ]
    found = calibrate_camera([*bad, *good], CalibrationSpec(board=board))
    assert (found.width_px, found.height_px) == (640, 480)
    reasons = dict(found.rejected)
    assert set(reasons) == {"empty", "unread", "small", "dot"}
    assert "chessboard" in reasons["empty"]
    assert "320 × 240" in reasons["small"]


def test_a_view_whose_points_are_wrong_is_left_out():
    good = photos()
    name, image = good[0]
    x, y = np.meshgrid(np.arange(640, dtype=np.float32), np.arange(480, dtype=np.float32))
    bent = cv2.remap(image, x + 12 * np.sin(y / 40), y, cv2.INTER_LINEAR)
    found = calibrate_camera([("bent " + name, bent), *good[1:]], CalibrationSpec(board=BOARDS["chessboard"]))
    assert [rejected[0] for rejected in found.rejected] == ["bent " + name]
    assert found.rejected[0][1].count(" px") == 2


def test_too_few_images_are_refused():
    with refused("calibration-few-images", "2", "4"):
        calibrate_camera(photos()[:2], CalibrationSpec(board=BOARDS["chessboard"]))


def test_find_board_says_why_it_found_nothing():
    blank = np.zeros((100, 100), np.uint8)
    check_values(find_board(blank, BOARDS["charuco"]), 0)
    assert find_board(blank, BOARDS["circles"])


def test_a_calibration_is_read_by_opencv_and_comes_back(tmp_path):
    found = calibrate_camera(photos(), CalibrationSpec(board=BOARDS["chessboard"]))
    path = tmp_path / "camera.yaml"
    write_calibration(path, found)
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    np.testing.assert_allclose(
        storage.getNode("camera_matrix").mat()[[0, 1, 0, 1], [0, 1, 2, 2]], found.intrinsics_px
    )
    np.testing.assert_allclose(storage.getNode("distortion_coefficients").mat().ravel(), found.distortion)
    back = read_calibration(path)
    np.testing.assert_array_equal(back.intrinsics_px, found.intrinsics_px)
    np.testing.assert_array_equal(back.covariance, found.covariance)
    assert back.camera_spec() == found.camera_spec()


def test_the_file_of_opencvs_sample_is_read():
    assert read_calibration(PHOTOS / "left_intrinsics.yml").intrinsics_px[0] == pytest.approx(535.91573)


@pytest.mark.parametrize("text", ["", "camera_matrix: 3", "image_width: [", "\x00"])
def test_a_file_that_is_no_calibration_is_refused(tmp_path, text):
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with refused("calibration-file-unreadable"):
        read_calibration(path)


@pytest.mark.parametrize("name", BOARDS)
def test_a_board_is_written_in_true_size(tmp_path, name):
    write_board(tmp_path / "board.pdf", BOARDS[name])
    content = (tmp_path / "board.pdf").read_bytes()
    assert content.startswith(b"%PDF")
    if name == "charuco":
        width, height = (13 * 29 / 25.4 * 72, 10 * 29 / 25.4 * 72)
        box = content.split(b"/MediaBox [")[1].split(b"]")[0].split()
        np.testing.assert_allclose([float(box[2]), float(box[3])], [width, height], rtol=1e-4)


def test_read_board_reads_words_and_refuses_what_is_none():
    assert read_board("charuco") == BoardSpec()
    assert read_board("chessboard:7x5:30").square == 30.0
    assert read_board("charuco:5x4:10:7:DICT_5X5_50").dictionary == "DICT_5X5_50"
    with refused("board-unknown", "chess"):
        read_board("chess")
    for text in ("charuco:5", "charuco:5x4:a"):
        with refused("board-malformed", text):
            read_board(text)


def test_a_dictionary_that_is_too_small_or_unknown_is_refused():
    blank = np.zeros((100, 100), np.uint8)
    with refused("board-dictionary-unknown", "DICT_NONE"):
        find_board(blank, BoardSpec(dictionary="DICT_NONE"))
    with refused("board-dictionary-too-small", "180"):
        find_board(blank, BoardSpec(columns=20, rows=18))


def test_damaged_and_giant_files_are_refused(tmp_path):
    photo = (PHOTOS / "left01.jpg").read_bytes()
    (tmp_path / "no.png").write_text("no image")
    (tmp_path / "cut.jpg").write_bytes(photo[:40])
    with refused("image-format-unknown", "no.png"):
        read_image(tmp_path / "no.png")
    with refused(("image-unreadable", "image-damaged", "image-format-unknown"), "cut.jpg"):
        read_image(tmp_path / "cut.jpg")
    cv2.imwrite(str(tmp_path / "large.png"), np.zeros((7000, 7000), np.uint8))
    with refused("image-too-large", "7000", "40"):
        read_image(tmp_path / "large.png")
    with refused("image-unreadable", "absent.png"):
        read_image(tmp_path / "absent.png")
    (tmp_path / "empty").mkdir()
    with refused("folder-no-image", "empty"):
        list_images(tmp_path / "empty")
    with refused("folder-missing", "nowhere"):
        list_images(tmp_path / "nowhere")
