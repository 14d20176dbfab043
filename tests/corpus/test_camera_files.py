"""Camera files of OpenCV, ROS and Kalibr, drawn with a seed, against OpenCV's own projection of the same lens."""

import json
from pathlib import Path

import cv2
import h5py
import numpy as np
import pytest
from scipy.io import savemat

from errors import refused
from palpate.camera import read_calibration

RANDOM = np.random.default_rng(49)
POINTS = RANDOM.uniform([-0.4, -0.3, 1], [0.4, 0.3, 1], (40, 3))
FX, FY, CX, CY = (float(value) for value in RANDOM.uniform([280, 280, 170, 125], [310, 310, 180, 135]).round(3))
MATRIX = np.array([[FX, 0, CX], [0, FY, CY], [0, 0, 1]])
FLAT = [FX, 0, CX, 0, FY, CY, 0, 0, 1]
SIZE = (346, 260)
LENS = {
    4: [-0.31, 0.11, 0.0007, -0.0004],
    5: [-0.31, 0.11, 0.0007, -0.0004, -0.02],
    8: [2.1, 0.6, 0.0007, -0.0004, 0.01, 2.3, 0.8, 0.03],
    12: [2.1, 0.6, 0.0007, -0.0004, 0.01, 2.3, 0.8, 0.03, 0.002, -0.001, 0.001, 0.002],
    14: [2.1, 0.6, 0.0007, -0.0004, 0.01, 2.3, 0.8, 0.03, 0.002, -0.001, 0.001, 0.002, 0, 0],
    "fisheye": [0.03, -0.02, 0.014, -0.011],
}


def opencv_yaml(values: list[float], model: str = "", head: str = "%YAML:1.0", size: bool = True) -> str:
    text = f"{head}\n---\n" + (f"image_width: {SIZE[0]}\nimage_height: {SIZE[1]}\n" if size else "")
    for name, data, rows in (("camera_matrix", FLAT, 3), ("distortion_coefficients", values, len(values))):
        text += f"{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {len(data) // rows}\n   dt: d\n"
        text += "   data: [ " + ",\n       ".join(map(repr, data)) + " ]\n"
    return text + (f"distortion_model: {model}\n" if model else "")


def opencv_xml(values: list[float], names: tuple[str, str] = ("camera_matrix", "distortion_coefficients")) -> str:
    blocks = "".join(
        f'<{name} type_id="opencv-matrix">\n<rows>{rows}</rows>\n<cols>{len(data) // rows}</cols>\n<dt>d</dt>\n'
        f"<data>\n{' '.join(map(repr, data))}</data></{name}>\n"
        for name, data, rows in ((names[0], FLAT, 3), (names[1], values, len(values)))
    )
    size = f"<image_width>{SIZE[0]}</image_width>\n<image_height>{SIZE[1]}</image_height>\n"
    return f'<?xml version="1.0"?>\n<opencv_storage>\n{size}{blocks}</opencv_storage>\n'


def ros_yaml(values: list[float], model: str) -> str:
    return (
        f"image_width: {SIZE[0]}\nimage_height: {SIZE[1]}\ncamera_name: tactile\n"
        f"camera_matrix:\n  rows: 3\n  cols: 3\n  data: {FLAT}\ndistortion_model: {model}\n"
        f"distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: {values}\n"
    )


def numbers(prefix: str, values: list[float], names: str = "k1 k2 p1 p2 k3") -> str:
    pairs = {"fx": FX, "fy": FY, "cx": CX, "cy": CY, "width": SIZE[0], "height": SIZE[1]}
    pairs |= dict(zip(names.split(), values, strict=False))
    return "".join(f"{prefix}{key}: {value}\n" for key, value in pairs.items())


def ros_echo(values: list[float], model: str, names: str = "dk", blocks: bool = True) -> str:
    d, k = names
    lists = {d: values, k: FLAT}
    text = "header:\n  stamp:\n    sec: 1\n    nanosec: 2\n  frame_id: tactile\n"
    text += f"height: {SIZE[1]}\nwidth: {SIZE[0]}\ndistortion_model: {model}\n"
    for name, data in lists.items():
        text += f"{name}:\n" + "".join(f"- {x}\n" for x in data) if blocks else f"{name}: {data}\n"
    return text + "binning_x: 0\nroi:\n  x_offset: 0\n  height: 0\n  width: 0\n---\n"


def ost_ini(values: list[float]) -> str:
    rows = "\n".join(" ".join(f"{value:.9f}" for value in FLAT[at : at + 3]) for at in (0, 3, 6))
    return (
        f"# oST version 5.0 parameters\n\n[image]\n\nwidth\n{SIZE[0]}\n\nheight\n{SIZE[1]}\n\n[narrow_stereo]\n\n"
        f"camera matrix\n{rows}\n\ndistortion\n{' '.join(map(repr, values))}\n\nrectification\n"
        "1 0 0\n0 1 0\n0 0 1\n\nprojection\n300 0 170 0\n0 300 128 0\n0 0 1 0\n"
    )


def kalibr(values: list[float], model: str) -> str:
    return (
        f"cam0:\n  camera_model: pinhole\n  distortion_coeffs: {values}\n  distortion_model: {model}\n"
        f"  intrinsics: [{FX}, {FY}, {CX}, {CY}]\n  resolution: [{SIZE[0]}, {SIZE[1]}]\n"
    )


def colmap(model: str, *values: float) -> str:
    rows = [FX, FY, CX + 0.5, CY + 0.5, *values]
    return (
        "# Camera list\n#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
        + f"1 {model} {SIZE[0]} {SIZE[1]} "
        + (" ".join(map(repr, rows)) + "\n")
    )


def matlab(values: list[float], key: str = "IntrinsicMatrix") -> dict[str, object]:
    k1, k2, p1, p2, k3 = values
    whole = np.array([[FX, 0, CX + 1], [0, FY, CY + 1], [0, 0, 1]])
    about = {"RadialDistortion": [k1, k2, k3], "TangentialDistortion": [p1, p2], "ImageSize": [SIZE[1], SIZE[0]]}
    if key == "FocalLength":
        return about | {"FocalLength": [FX, FY], "PrincipalPoint": [CX + 1, CY + 1]}
    return about | {key: whole.T.tolist() if key == "IntrinsicMatrix" else whole.tolist()}


def write_mat(path: Path) -> None:
    savemat(path, {"cameraParams": {name: np.array(value, float) for name, value in matlab(LENS[5]).items()}})


def json_lists(values: list[float]) -> str:
    return json.dumps({"cameraMatrix": MATRIX.tolist(), "distCoeffs": [values], "imageSize": list(SIZE)}, indent=1)


def json_blocks(values: list[float]) -> str:
    block = {"type_id": "opencv-matrix", "rows": 3, "cols": 3, "dt": "d", "data": FLAT}
    lens = {"type_id": "opencv-matrix", "rows": 1, "cols": len(values), "dt": "d", "data": values}
    about = {"image_width": SIZE[0], "image_height": SIZE[1]}
    return json.dumps(about | {"camera_matrix": block, "distortion_coefficients": lens}, indent="\t")


READ = {
    **{f"opencv_{n}.yaml": (opencv_yaml(LENS[n]), n) for n in (4, 5, 8, 12, 14)},
    **{f"opencv_{n}.xml": (opencv_xml(LENS[n]), n) for n in (4, 5, 8, 14)},
    **{f"opencv_{n}.json": (json_blocks(LENS[n]), n) for n in (5, 8, 12)},
    "old_sample.xml": (opencv_xml(LENS[5], ("Camera_Matrix", "Distortion_Coefficients")), 5),
    "lists.json": (json_lists(LENS[5]), 5),
    "yaml_1_2.yaml": (opencv_yaml(LENS[8], head="%YAML 1.2"), 8),
    "opencv_fisheye.yaml": (opencv_yaml(LENS["fisheye"]) + "fisheye_model: 1\n", "fisheye"),
    "ros_plumb_bob.yaml": (ros_yaml(LENS[5], "plumb_bob"), 5),
    "ros_rational.yaml": (ros_yaml(LENS[8], "rational_polynomial"), 8),
    "ros_rational_in_capitals.yaml": (ros_yaml(LENS[8], "RATIONAL_POLYNOMIAL"), 8),
    **{f"{name}.yaml": (ros_yaml(LENS["fisheye"], name), "fisheye") for name in ("equidistant", "fisheye")},
    **{f"{name}.yaml": (ros_yaml(LENS["fisheye"], name), "fisheye") for name in ("kannala_brandt", "kannala-brandt")},
    "fisheye_with_zeros.yaml": (ros_yaml([*LENS["fisheye"], 0.0, 0.0], "equidistant"), "fisheye"),
    "echo_ros2.yaml": (ros_echo(LENS[5], "plumb_bob"), 5),
    "echo_ros2_rational.txt": (ros_echo(LENS[8], "rational_polynomial"), 8),
    "echo_ros2_two_messages.yaml": (ros_echo(LENS[5], "plumb_bob") * 2, 5),
    "echo_ros1.yaml": (ros_echo(LENS[5], '"plumb_bob"', "DK", blocks=False), 5),
    "echo_ros1_fisheye.yaml": (ros_echo(LENS["fisheye"], '"equidistant"', "DK", blocks=False), "fisheye"),
    "ost.ini": (ost_ini(LENS[5]), 5),
    "ost.txt": (ost_ini(LENS[5]).replace("\n", "\r\n"), 5),
    "numbers.yaml": (numbers("", LENS[4]), 4),
    "numbers_of_orb_slam.yaml": ("%YAML:1.0\n---\n" + numbers("Camera.", LENS[5]), 5),
    "numbers_of_a_fisheye.yaml": (numbers("", LENS["fisheye"], "k1 k2 k3 k4"), "fisheye"),
    "nerfstudio.json": (
        json.dumps(
            {"camera_model": "OPENCV", "fl_x": FX, "fl_y": FY, "cx": CX, "cy": CY, "w": SIZE[0], "h": SIZE[1]}
            | dict(zip(("k1", "k2", "p1", "p2"), LENS[4], strict=True))
        ),
        4,
    ),
    "realsense.json": (
        json.dumps(
            {"width": SIZE[0], "height": SIZE[1], "ppx": CX, "ppy": CY, "fx": FX, "fy": FY}
            | {"model": "distortion.brown_conrady", "coeffs": LENS[5]}
        ),
        5,
    ),
    "vins.yaml": (
        f"%YAML:1.0\n---\nmodel_type: PINHOLE\nimage_width: {SIZE[0]}\nimage_height: {SIZE[1]}\n"
        + "distortion_parameters:\n"
        + "".join(f"   {name}: {value}\n" for name, value in zip(("k1", "k2", "p1", "p2"), LENS[4], strict=True))
        + f"projection_parameters:\n   fx: {FX}\n   fy: {FY}\n   cx: {CX}\n   cy: {CY}\n",
        4,
    ),
    "by_columns.json": (
        json.dumps({"cameraMatrix": MATRIX.T.tolist(), "distCoeffs": [LENS[5]], "imageSize": list(SIZE)}),
        5,
    ),
    "groups.json": (
        json.dumps(
            {
                "intrinsics": {"fx": FX, "fy": FY, "cx": CX, "cy": CY},
                "imageSize": {"width": SIZE[0], "height": SIZE[1]},
                "distCoeffs": LENS[5],
            }
        ),
        5,
    ),
    "euroc.yaml": (
        f"resolution: [{SIZE[0]}, {SIZE[1]}]\ncamera_model: pinhole\nintrinsics: [{FX}, {FY}, {CX}, {CY}]\n"
        f"distortion_model: radial-tangential\ndistortion_coefficients: {LENS[4]}\n",
        4,
    ),
    "cameras.txt": (colmap("OPENCV", *LENS[4]), 4),
    "cameras_full.txt": (colmap("FULL_OPENCV", *LENS[8]), 8),
    "cameras_fisheye.txt": (colmap("OPENCV_FISHEYE", *LENS["fisheye"]), "fisheye"),
    "to_struct.json": (json.dumps(matlab(LENS[5])), 5),
    "camchain.yaml": (kalibr(LENS[4], "radtan"), 4),
    "camchain_fisheye.yaml": (kalibr(LENS["fisheye"], "equidistant"), "fisheye"),
}

REFUSED = {
    "tilted.yaml": (opencv_yaml([*LENS[12], 0.01, 0.02]), "lens-model-unknown"),
    "four_of_what.yaml": (opencv_yaml(LENS["fisheye"]), "lens-model-ambiguous"),
    "no_size.yaml": (opencv_yaml(LENS[5], size=False), "calibration-file-unreadable"),
    "six.yaml": (opencv_yaml([*LENS[5], 0.1]), "lens-coefficient-count"),
    "fov.yaml": (ros_yaml([0.9], "fov"), "lens-coefficient-count"),
    "uncalibrated.yaml": (
        ros_echo([0.0] * 5, "plumb_bob").replace(f"- {FX}", "- 0.0"),
        "calibration-file-unreadable",
    ),
    "two_cameras.yaml": (
        kalibr(LENS[4], "radtan") + kalibr(LENS[4], "radtan").replace("cam0", "cam1"),
        "calibration-several-cameras",
    ),
    "two_cameras.ini": (
        ost_ini(LENS[5]) + ost_ini(LENS[5]).partition("[narrow_stereo]")[2].join(("[right]", "")),
        "calibration-several-cameras",
    ),
    "colmap_two.txt": (colmap("OPENCV", *LENS[4]) * 2, "calibration-several-cameras"),
    "colmap_fov.txt": (colmap("FOV", 0.9), "lens-model-unknown"),
    "colmap_short.txt": (colmap("OPENCV", 0.1), "lens-model-unknown"),
    "stereo.json": (
        json.dumps({"CameraParameters1": matlab(LENS[5]), "CameraParameters2": matlab(LENS[5])}),
        "calibration-several-cameras",
    ),
    "entities.xml": ('<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "c">]><a>&b;</a>', "calibration-file-unreadable"),
    "half.xml": (opencv_xml(LENS[5])[:300], "calibration-file-unreadable"),
    "half.json": (json_lists(LENS[5])[:60], "calibration-file-unreadable"),
    "nan.yaml": (opencv_yaml([float("nan")] * 5).replace("nan", ".nan"), "calibration-file-unreadable"),
    "empty.yaml": ("", "calibration-file-unreadable"),
    "prose.txt": ("The camera has fx 300.", "calibration-file-unreadable"),
}


@pytest.mark.parametrize("name", READ)
def test_a_camera_file_gives_the_projection_of_opencv(name: str, tmp_path: Path) -> None:
    text, lens = READ[name]
    path = tmp_path / name
    path.write_bytes(text.encode())
    found = read_calibration(path)
    assert (found.width_px, found.height_px) == SIZE
    fx, fy, cx, cy = found.intrinsics_px
    seen = found.lens.distort(POINTS[:, :2]) * [fx, fy] + [cx, cy]
    values = np.array(LENS[lens])
    if lens == "fisheye":
        expected, _ = cv2.fisheye.projectPoints(POINTS[:, None], np.zeros(3), np.zeros(3), MATRIX, values)
    else:
        expected, _ = cv2.projectPoints(POINTS, np.zeros(3), np.zeros(3), MATRIX, values)
    expected = expected[:, 0]
    assert seen == pytest.approx(expected, abs=1e-8)
    assert found.lens.undistort((expected - [cx, cy]) / [fx, fy]) == pytest.approx(POINTS[:, :2], abs=1e-8)
    if lens != "fisheye":
        stop = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 200, 1e-14)
        theirs = (
            cv2.undistortPointsIter(expected[:, None], MATRIX, values, None, None, stop)[:, 0]
            if hasattr(cv2, "undistortPointsIter")
            else cv2.undistortPoints(expected[:, None], MATRIX, values, None, None, None, stop)[:, 0]
        )
        assert found.lens.undistort((expected - [cx, cy]) / [fx, fy]) == pytest.approx(theirs, abs=1e-6)


@pytest.mark.parametrize("name", REFUSED)
def test_a_camera_file_that_says_too_little_is_refused_in_a_sentence(name: str, tmp_path: Path) -> None:
    text, code = REFUSED[name]
    path = tmp_path / name
    path.write_text(text)
    with refused(code, name) as caught:
        read_calibration(path)
    assert caught.value.remedy
    assert "\n" not in caught.value.problem


@pytest.mark.parametrize("sized", [True, False])
def test_arrays_of_opencv_are_read_if_they_state_the_size_of_the_image(sized: bool, tmp_path: Path) -> None:
    path = tmp_path / "calibration.npz"
    size = {"image_size": np.array(SIZE)} if sized else {}
    np.savez(path, mtx=MATRIX, dist=np.array([LENS[5]]), rvecs=np.zeros((3, 3, 1)), **size)
    if sized:
        assert read_calibration(path).intrinsics_px == pytest.approx([FX, FY, CX, CY])
        return
    with refused("calibration-file-unreadable", "image_width"):
        read_calibration(path)


@pytest.mark.parametrize(
    ("text", "lens"),
    [
        (f"1 SIMPLE_PINHOLE {SIZE[0]} {SIZE[1]} 300 173 130", np.zeros(5)),
        (f"1 PINHOLE {SIZE[0]} {SIZE[1]} 300 300 173 130", np.zeros(5)),
        (f"1 SIMPLE_RADIAL {SIZE[0]} {SIZE[1]} 300 173 130 -0.2", np.array([-0.2, 0, 0, 0, 0])),
        (f"1 RADIAL {SIZE[0]} {SIZE[1]} 300 173 130 -0.2 0.05", np.array([-0.2, 0.05, 0, 0, 0])),
        (f"1 RADIAL_FISHEYE {SIZE[0]} {SIZE[1]} 300 173 130 -0.2 0.05", np.array([-0.2, 0.05, 0, 0])),
    ],
)
def test_models_of_colmap_have_their_coefficients(text: str, lens: np.ndarray, tmp_path: Path) -> None:
    path = tmp_path / "cameras.txt"
    path.write_text(text + "\n")
    found = read_calibration(path)
    assert found.intrinsics_px == pytest.approx([300, 300, 172.5, 129.5])
    assert found.distortion == pytest.approx(lens)


@pytest.mark.parametrize("key", ["IntrinsicMatrix", "K", "FocalLength"])
@pytest.mark.parametrize("version", ["5", "7.3"])
@pytest.mark.parametrize("nested", [True, False])
def test_a_file_of_matlab_has_its_first_pixel_at_1(key: str, version: str, nested: bool, tmp_path: Path) -> None:
    path = tmp_path / "camera.mat"
    arrays = {name: np.array(value, float) for name, value in matlab(LENS[5], key).items()}
    if version == "5":
        savemat(path, {"cameraParams": arrays} if nested else arrays)
    else:
        with h5py.File(path, "w", userblock_size=512) as file:
            group = file.create_group("cameraParams") if nested else file
            for name, value in arrays.items():
                group[name] = np.atleast_2d(value).T
    found = read_calibration(path)
    assert (found.width_px, found.height_px) == SIZE
    assert found.intrinsics_px == pytest.approx([FX, FY, CX, CY])
    assert found.distortion == pytest.approx(LENS[5])


def test_an_object_of_matlab_is_refused_by_its_name(tmp_path: Path) -> None:
    path = tmp_path / "camera.mat"
    with h5py.File(path, "w") as file:
        file.create_group("#subsystem#")
    with refused("calibration-file-unreadable", "object of MATLAB"):
        read_calibration(path)
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\1IM" + b"\1" * 40)
    with refused("calibration-file-unreadable", "camera.mat"):
        read_calibration(path)
