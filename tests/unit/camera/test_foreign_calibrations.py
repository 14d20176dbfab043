"""Calibrations of ROS and Kalibr, as their tools write them, against OpenCV's projection."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from errors import refused
from palpate.camera import read_calibration

POINTS = np.random.default_rng(4).uniform([-0.5, -0.4, 1], [0.5, 0.4, 1], (60, 3))
INTRINSICS = (261.2, 260.4, 171.9, 129.3)
MATRIX = np.array([[INTRINSICS[0], 0, INTRINSICS[2]], [0, INTRINSICS[1], INTRINSICS[3]], [0, 0, 1]])
BENT = (-0.36, 0.15, 0.0007, -0.0004)

ROS = """image_width: 346
image_height: 260
camera_name: davis
camera_matrix:
  rows: 3
  cols: 3
  data: [261.2, 0, 171.9, 0, 260.4, 129.3, 0, 0, 1]
distortion_model: {model}
distortion_coefficients:
  rows: 1
  cols: {count}
  data: [{data}]
"""
KALIBR = """{name}:
  cam_overlaps: []
  camera_model: {camera}
  distortion_coeffs: [{data}]
  distortion_model: {model}
  intrinsics: [261.2, 260.4, 171.9, 129.3]
  resolution: [346, 260]
  rostopic: /image
"""


def seen_px(path: Path) -> np.ndarray:
    found = read_calibration(path)
    fx, fy, cx, cy = found.intrinsics_px
    assert (found.width_px, found.height_px) == (346, 260)
    return found.lens.distort(POINTS[:, :2]) * [fx, fy] + [cx, cy]


def kalibr(model: str, data: tuple[float, ...], camera: str = "pinhole", name: str = "cam0") -> str:
    return KALIBR.format(name=name, camera=camera, model=model, data=", ".join(map(repr, data)))


def test_plumb_bob_with_four_coefficients_has_no_k3(tmp_path: Path) -> None:
    path = tmp_path / "ost.yaml"
    path.write_text(ROS.format(model="plumb_bob", count=4, data=", ".join(map(repr, BENT))))
    expected = cv2.projectPoints(POINTS, np.zeros(3), np.zeros(3), MATRIX, np.array(BENT))[0][:, 0]
    assert seen_px(path) == pytest.approx(expected, abs=1e-9)
    assert read_calibration(path).lens.coefficients[-1] == 0


@pytest.mark.parametrize(("model", "count"), [("plumb_bob", 3), ("rational_polynomial", 7), ("equidistant", 5)])
def test_other_counts_and_models_are_refused(model: str, count: int, tmp_path: Path) -> None:
    path = tmp_path / "ost.yaml"
    path.write_text(ROS.format(model=model, count=count, data=", ".join(["0.01"] * count)))
    with refused("lens-coefficient-count", count, model):
        read_calibration(path)


def test_a_camchain_of_kalibr_is_read(tmp_path: Path) -> None:
    path = tmp_path / "camchain.yaml"
    path.write_text(kalibr("radtan", BENT))
    expected = cv2.projectPoints(POINTS, np.zeros(3), np.zeros(3), MATRIX, np.array(BENT))[0][:, 0]
    assert seen_px(path) == pytest.approx(expected, abs=1e-9)
    fisheye = (0.03, -0.01, 0.004, -0.001)
    path.write_text(kalibr("equidistant", fisheye, name="cam1"))
    expected = cv2.fisheye.projectPoints(POINTS[:, None], np.zeros(3), np.zeros(3), MATRIX, np.array(fisheye))[0][
        :, 0
    ]
    assert seen_px(path) == pytest.approx(expected, abs=1e-9)
    path.write_text(kalibr("none", ()))
    assert seen_px(path) == pytest.approx(POINTS[:, :2] * INTRINSICS[:2] + INTRINSICS[2:], abs=1e-9)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (kalibr("radtan", BENT, camera="omni"), ("lens-model-unknown", "omni-radtan")),
        (kalibr("fov", (0.9,)), ("lens-model-unknown", "pinhole-fov")),
        (
            kalibr("radtan", BENT) + kalibr("radtan", BENT, name="cam1"),
            ("calibration-several-cameras", "cam0, cam1"),
        ),
        (kalibr("radtan", BENT[:2]), ("lens-coefficient-count", "2")),
        ("cam0: 3\n", ("calibration-file-unreadable",)),
        ("- 1\n", ("calibration-file-unreadable",)),
    ],
)
def test_what_cannot_be_read_of_a_camchain_is_refused_in_a_sentence(
    text: str, says: tuple[str, ...], tmp_path: Path
) -> None:
    path = tmp_path / "camchain.yaml"
    path.write_text(text)
    with refused(*says) as caught:
        read_calibration(path)
    assert caught.value.remedy
