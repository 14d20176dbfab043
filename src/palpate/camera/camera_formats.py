"""Conversion of camera files of other tools to the keys of ROS's ``camera_info`` YAML.

Supported are: YAML, XML and JSON of OpenCV's FileStorage; ROS's YAML, ``ost.ini`` and the dump of ``topic echo`` of a
``CameraInfo`` (ROS 1 and 2); a camchain of Kalibr; a struct of MATLAB (.mat or JSON); ``cameras.txt`` of COLMAP; fx,
fy, cx, cy, k1 … as single numbers, such as those of ORB-SLAM, VINS and nerfstudio. Matrices may be blocks with
``data``, nested or flat lists.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from ruamel.yaml import YAML

from palpate.core import PalpateError, reject_external_links

KALIBR_LENSES = {"radtan": "plumb_bob", "equidistant": "equidistant", "equi": "equidistant", "none": "plumb_bob"}
"""Lens models of ROS by their names in Kalibr."""
_INTRINSICS = (("fx", "fl_x"), ("fy", "fl_y"), ("cx", "ppx", "c_x"), ("cy", "ppy", "c_y"))
_CAMERA = re.compile(r"cam\d+")
_NAMES = {
    "camera_matrix": ("k", "cameramatrix", "camera_matrix", "mtx", "intrinsic_matrix"),
    "distortion_coefficients": (
        *("d", "distcoeffs", "dist_coeffs", "dist_coeff", "dist", "distortion_coefficients", "distortion"),
        *("distortion_coeffs", "distcoefs", "coeffs", "distortion_parameters"),
    ),
    "image_width": ("image_width", "width", "w"),
    "image_height": ("image_height", "height", "h"),
    "image_size": ("image_size", "imagesize", "resolution"),
    "distortion_model": ("distortion_model", "model", "lens_model"),
}
"""Names of each key in files, in lower case, by the key of ROS."""
_COLMAP = {
    **{"SIMPLE_PINHOLE": "f cx cy", "PINHOLE": "fx fy cx cy", "OPENCV": "fx fy cx cy k1 k2 p1 p2"},
    **dict.fromkeys(("SIMPLE_RADIAL", "SIMPLE_RADIAL_FISHEYE"), "f cx cy k1"),
    **dict.fromkeys(("RADIAL", "RADIAL_FISHEYE"), "f cx cy k1 k2"),
    **{"OPENCV_FISHEYE": "fx fy cx cy k1 k2 k3 k4", "FULL_OPENCV": "fx fy cx cy k1 k2 p1 p2 k3 k4 k5 k6"},
}
"""Parameters of each camera model of COLMAP."""


def read_camera_file(path: Path) -> dict[str, Any]:
    """Return the content of a camera file by the keys of ROS's ``camera_info`` YAML.

    Raises
    ------
    PalpateError
        If it has several cameras, a model that palpate does not support, or no camera matrix or image size.
    ValueError
        If the text does not have its format; ruamel and ElementTree raise their own errors.
    """
    name = path.name
    if path.suffix.lower() == ".npz":
        with np.load(path, allow_pickle=False) as file:
            arrays = {key: file[key] for key in file.files}
        return _by_ros_keys(name, {key: one.item() if one.size == 1 else one.tolist() for key, one in arrays.items()})
    if path.suffix.lower() == ".mat":
        return _by_ros_keys(name, _from_matlab(name, _read_mat(path)))
    start = path.read_text(encoding="utf-8").lstrip("\ufeff \r\n\t")
    if start.startswith("<"):
        content = _read_xml(start)
    elif start.startswith(("{", "[\n", "[ ")):
        content = json.loads(start)
    elif re.search(r"^\[image\]\s*$", start, re.MULTILINE):
        content = _read_ini(name, start)
    elif rows := re.findall(r"^\d+[ \t]+([A-Z_]{3,})((?:[ \t]+[-+.\deE]+)+)[ \t]*$", start, re.MULTILINE):
        content = _from_colmap(name, rows)
    else:
        content = _read_yaml(start)
    if not isinstance(content, dict):
        raise ValueError("it contains no keys")
    return _by_ros_keys(name, _from_matlab(name, _from_kalibr(name, content)))


def _read_mat(path: Path) -> dict[str, Any]:
    """Return the variables of a MATLAB file; arrays of version 7.3 (HDF5) are transposed."""
    import h5py  # here, because both are slow to load
    from scipy.io import loadmat

    def content(group: Any) -> dict[str, Any]:
        return {key: content(item) if isinstance(item, h5py.Group) else item[()] for key, item in group.items()}

    if h5py.is_hdf5(path):
        with h5py.File(path, "r") as file:
            reject_external_links(file, path)
            found = content(file)
    else:
        found = loadmat(path, simplify_cells=True)
    if {"#subsystem#", "__function_workspace__"} & set(found):
        raise PalpateError(
            f"{path.name} holds an object of MATLAB, which only MATLAB reads.",
            "Save a struct: camera = toStruct(cameraParams); save('camera.mat', 'camera').",
            code="calibration-file-unreadable",
        )
    return found


def _from_matlab(name: str, content: dict[str, Any]) -> dict[str, Any]:
    """Convert a struct of MATLAB, whose first pixel has its centre at 1; return others unchanged."""
    groups = {"": content} | {key: value for key, value in content.items() if isinstance(value, Mapping)}
    structs = {key: {str(own).lower(): value for own, value in group.items()} for key, group in groups.items()}
    found = {key: one for key, one in structs.items() if "radialdistortion" in one}
    _only(name, list(found))
    if not found:
        return content
    (low,) = found.values()
    matrix = np.reshape(low.get("intrinsicmatrix", low.get("k", np.zeros(9))), (3, 3))
    fx, fy = np.ravel(low.get("focallength", matrix[[0, 1], [0, 1]]))
    cx, cy = np.ravel(low.get("principalpoint", matrix[2, :2] if matrix[2, :2].any() else matrix[:2, 2])) - 1
    radial = [*np.ravel(low["radialdistortion"]).tolist(), 0.0, 0.0]
    lens = [*radial[:2], *np.ravel(low.get("tangentialdistortion", (0, 0))).tolist(), radial[2]]
    size = dict(zip(("h", "w"), np.ravel(low.get("imagesize", ())).tolist(), strict=False))
    return size | {"intrinsics": [fx, fy, cx, cy], "dist": lens, "distortion_model": "plumb_bob"}


def _from_colmap(name: str, rows: list[tuple[str, str]]) -> dict[str, Any]:
    """Convert ``cameras.txt`` of COLMAP, whose first pixel has its centre at 0.5."""
    _only(name, [model for model, _ in rows])
    ((model, text),) = rows
    numbers = [float(word) for word in text.split()]
    keys = ["w", "h", *_COLMAP.get(model, "").split()]
    if len(keys) != len(numbers):
        raise _unknown(name, f"COLMAP's model {model} with {len(numbers) - 2} parameters", ", ".join(_COLMAP))
    found: dict[str, Any] = {"k1": 0.0, "camera_model": model} | dict(zip(keys, numbers, strict=True))
    found |= {"fx": found["f"], "fy": found["f"]} if "f" in found else {}
    return found | {"cx": found["cx"] - 0.5, "cy": found["cy"] - 0.5}


def _unknown(name: str, model: str, known: str) -> PalpateError:
    return PalpateError(
        f"{name} has {model}, which palpate does not support.", f"Calibrate with {known}.", code="lens-model-unknown"
    )


def _read_yaml(text: str) -> Any:
    """Return the first document of a YAML file, with or without the marks of OpenCV."""
    lines = ["" if line.startswith("%YAML") else line.replace("!!opencv-matrix", "") for line in text.splitlines()]
    return next((content for content in YAML(typ="safe").load_all("\n".join(lines)) if content is not None), None)


def _read_xml(text: str) -> dict[str, Any]:
    """Return the content of OpenCV's XML; entities are rejected, since their size is not bounded."""
    if "<!ENTITY" in text.upper():
        raise ValueError("it declares entities")
    content: dict[str, Any] = {}
    for node in ElementTree.fromstring(text):
        inner = {child.tag: (child.text or "").strip() for child in node}
        words = (node.text or "").split()
        content[node.tag] = inner | {"data": inner["data"].split()} if "data" in inner else words[0] if words else ""
        if "data" not in inner and len(words) > 1:
            content[node.tag] = words
    return content


def _read_ini(file: str, text: str) -> dict[str, Any]:
    """Return the content of ``ost.ini`` of camera_calibration: a name, and its numbers on the lines below."""
    content: dict[str, Any] = {}
    name = ""
    for line in map(str.strip, text.splitlines()):
        if not line or line.startswith("#"):
            continue
        if line.startswith("["):
            content.setdefault("sections", []).append(line)
            continue
        key, _, value = line.partition("=")
        words = (value or key).split()
        if re.match(r"[-+.\d]", words[0]):
            if value:
                name = key.strip()
            content.setdefault(name.replace(" ", "_"), []).extend(words)
        else:
            name = line
    cameras = [section for section in content.pop("sections") if section not in ("[image]", "[externals]")]
    _only(file, cameras)
    return {key: values[0] if len(values) == 1 else values for key, values in content.items()}


def _only(name: str, cameras: Sequence[str]) -> None:
    """Raise an error if a file contains several cameras, given by their names."""
    if len(cameras) > 1:
        raise PalpateError(
            f"{name} contains {len(cameras)} cameras: {', '.join(cameras)}.",
            "Copy one camera to a separate file.",
            code="calibration-several-cameras",
        )


def _from_kalibr(name: str, content: dict[str, Any]) -> dict[str, Any]:
    """Convert a camchain of Kalibr to the keys of ROS; return any other content unchanged."""
    chain = {key: value for key, value in content.items() if _CAMERA.fullmatch(str(key))}
    if not chain:
        return content
    _only(name, list(chain))
    (camera,) = chain.values()
    model, lens = str(camera["camera_model"]), str(camera.get("distortion_model", "none"))
    if model != "pinhole" or lens not in KALIBR_LENSES:
        raise _unknown(name, f"Kalibr's model {model}-{lens}", "pinhole-radtan or pinhole-equi")
    fx, fy, cx, cy = (float(value) for value in camera["intrinsics"])
    return {
        "image_size": camera["resolution"],
        "camera_matrix": [fx, 0, cx, 0, fy, cy, 0, 0, 1],
        "distortion_model": KALIBR_LENSES[lens],
        "distortion_coefficients": camera["distortion_coeffs"] if lens != "none" else [0, 0, 0, 0],
    }


def _from_numbers(name: str, low: dict[str, Any]) -> dict[str, Any]:
    """Keys, those of the groups of the lens too, and the matrices of numbers with own keys."""
    groups = {key: value for key, value in low.items() if isinstance(value, Mapping) and "data" not in value}
    low = {key: value for key, value in low.items() if key not in groups}
    if not any(key in low for key in _NAMES["camera_matrix"]):
        inner = {key: {str(own).lower(): value for own, value in group.items()} for key, group in groups.items()}
        lenses = [key for key, group in inner.items() if any(own in group for own in _INTRINSICS[0])]
        _only(name, lenses)
        for key in [
            *lenses,
            *(key for key in inner if key in (*_NAMES["image_size"], "distortion", "distortion_parameters", "lens")),
        ]:
            low = inner[key] | low
        values = low.get("intrinsics", [next((low[key] for key in keys if key in low), None) for keys in _INTRINSICS])
        if isinstance(values, list) and len(values) == 4 and None not in values:
            fx, fy, cx, cy = (float(value) for value in values)
            low["camera_matrix"] = [fx, 0, cx, 0, fy, cy, 0, 0, 1]
            low |= _coefficients(low)
    return low


def _coefficients(low: dict[str, Any]) -> dict[str, Any]:
    """Coefficients k1, p1 … with own keys, and their lens model; nothing if the file lists them."""
    if "k1" not in low or any(key in low for key in _NAMES["distortion_coefficients"]):
        return {}
    model = next((str(low[key]).lower() for key in (*_NAMES["distortion_model"], "camera_model") if key in low), "")
    four = [float(low.get(key, 0.0)) for key in ("k1", "k2", "k3", "k4")]
    straight = [float(low.get(key, 0.0)) for key in ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")]
    more = any(straight[6:]) or any(straight[2:4])
    if any(word in model for word in ("fisheye", "equi", "kannala")) or (not model and four[3] and not more):
        return {"distortion_coefficients": four, "distortion_model": "equidistant"}
    found: dict[str, Any] = {"distortion_coefficients": straight if any(straight[5:]) else straight[:5]}
    return found | ({"distortion_model": ""} if model == "opencv" else {})


def _by_ros_keys(name: str, content: dict[str, Any]) -> dict[str, Any]:
    low = _from_numbers(name, {str(key).lower().removeprefix("camera."): value for key, value in content.items()})
    found = {
        key: next(low[own] for own in names if low.get(own) is not None)
        for key, names in _NAMES.items()
        if any(low.get(own) is not None for own in names)
    }
    if (model := str(low.get("model_type", "pinhole"))).lower() != "pinhole":
        raise _unknown(name, f"the camera model {model}", "a pinhole model")
    if float(low.get("fisheye_model", 0) or 0):
        found["distortion_model"] = "equidistant"
    if "image_size" in found:
        found["image_width"], found["image_height"] = (float(one) for one in flat(found.pop("image_size")))
    missing = [key for key in ("camera_matrix", "image_width", "image_height") if key not in found]
    if missing:
        raise PalpateError(
            f"{name} is not a calibration: it has no {', no '.join(missing)}.",
            "Add it, as in ROS's camera_info YAML, or calibrate by `palpate calibration camera`.",
            code="calibration-file-unreadable",
        )
    return low | found


def flat(block: Any) -> list[Any]:
    """Return the numbers of a matrix: a block with ``data``, or flat or nested lists."""
    values = block["data"] if isinstance(block, Mapping) else block
    return [one for value in values for one in (flat(value) if isinstance(value, list) else [value])]
