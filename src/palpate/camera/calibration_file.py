"""Calibrations as YAML that OpenCV's FileStorage and ROS's camera_info both read.

ROS asks for ``camera_matrix``, ``distortion_coefficients``, ``rectification_matrix`` and ``projection_matrix`` with
rows, cols and data; OpenCV for the first line and the mark ``!!opencv-matrix``. ROS's reader passes over the mark.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from ruamel.yaml import YAML
from ruamel.yaml.error import YAMLError

from palpate.camera.calibration import Calibration
from palpate.camera.lens import LENSES, lens_from_model, make_lens
from palpate.core import FloatArray, PalpateError

_CAMERA = re.compile(r"cam\d+")
_KALIBR = {"radtan": "plumb_bob", "equidistant": "equidistant", "equi": "equidistant", "none": "plumb_bob"}
"""Lens models of ROS by their names in Kalibr."""


def write_calibration(path: Path, calibration: Calibration, name: str = "camera") -> None:
    """Write a calibration as YAML for OpenCV and ROS."""
    fx, fy, cx, cy = calibration.intrinsics_px
    matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])
    projection = np.column_stack([matrix, np.zeros(3)])
    lines = [
        "%YAML:1.0",
        "---",
        f"image_width: {calibration.width_px}",
        f"image_height: {calibration.height_px}",
        f'camera_name: "{name}"',
        _matrix("camera_matrix", matrix),
        f'distortion_model: "{calibration.model}"',
        _matrix("distortion_coefficients", calibration.distortion[None]),
        _matrix("rectification_matrix", np.eye(3)),
        _matrix("projection_matrix", projection),
        f"rms_px: {calibration.rms_px:.6g}",
        f"covered: {calibration.covered:.4g}",
    ]
    if np.isfinite(calibration.covariance).all():
        lines.append(_matrix("covariance", calibration.covariance))
    lines.append(_matrix("coverage", calibration.coverage.astype(float)))
    if len(calibration.image_rms_px):
        lines.append(_matrix("image_rms_px", calibration.image_rms_px[None]))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def read_calibration(path: Path) -> Calibration:
    """Read a calibration written by us, by OpenCV's sample, by ROS or by Kalibr (a camchain of one camera).

    ROS's ``plumb_bob`` with four coefficients has k3 = 0.

    Raises
    ------
    PalpateError
        If the file is no calibration, or its coefficients are not those of the lens model that it names.
    """
    try:
        text = path.read_text(encoding="utf-8")
        lines = [
            "" if line.startswith("%YAML") else line.replace("!!opencv-matrix", "") for line in text.splitlines()
        ]
        content = YAML(typ="safe").load("\n".join(lines))
        return _calibration(path.name, _from_kalibr(path.name, content))
    except (
        OSError,
        UnicodeDecodeError,
        YAMLError,
        KeyError,
        TypeError,
        ValueError,
        OverflowError,
        AttributeError,
    ) as error:
        raise PalpateError(
            f"{path.name} is not a calibration: {error}.", "Calibrate again.", code="calibration-file-unreadable"
        ) from error


def _from_kalibr(name: str, content: dict[str, Any]) -> dict[str, Any]:
    """The content as ROS writes it, of a camchain by Kalibr; any other content unchanged."""
    chain = {key: value for key, value in content.items() if _CAMERA.fullmatch(str(key))}
    if not chain:
        return content
    if len(chain) > 1:
        raise PalpateError(
            f"{name} holds {len(chain)} cameras: {', '.join(chain)}.",
            "Copy the one that is meant to a file of its own.",
            code="calibration-several-cameras",
        )
    (camera,) = chain.values()
    model, lens = str(camera["camera_model"]), str(camera.get("distortion_model", "none"))
    if model != "pinhole" or lens not in _KALIBR:
        raise PalpateError(
            f"{name} has Kalibr's model {model}-{lens}, which palpate does not have.",
            "Calibrate with pinhole-radtan or pinhole-equi.",
            code="lens-model-unknown",
        )
    fx, fy, cx, cy = (float(value) for value in camera["intrinsics"])
    width, height = camera["resolution"]
    return {
        "image_width": width,
        "image_height": height,
        "camera_matrix": {"data": [fx, 0, cx, 0, fy, cy, 0, 0, 1]},
        "distortion_model": _KALIBR[lens],
        "distortion_coefficients": {"data": camera["distortion_coeffs"] if lens != "none" else [0, 0, 0, 0]},
    }


def _calibration(name: str, content: dict[str, Any]) -> Calibration:
    matrix = _numbers(content["camera_matrix"], 9).reshape(3, 3)
    distortion = _numbers(content["distortion_coefficients"], None)
    named = content.get("distortion_model", "plumb_bob" if len(distortion) == 5 else None)
    kind = lens_from_model(str(named))
    if kind is lens_from_model("plumb_bob") and len(distortion) == 4:
        distortion = np.append(distortion, 0.0)
    if kind is None or len(distortion) != len(kind.parameters()):
        known = (f"{lens.model or key} takes {', '.join(lens.parameters())}" for key, lens in LENSES.available())
        raise PalpateError(
            f"{name} has {len(distortion)} coefficients for the lens model {named}.",
            f"{'; '.join(known)}: one is no stand-in for the other.",
            code="lens-coefficient-count",
        )
    size = 4 + len(distortion)
    covariance = _numbers(content["covariance"], size**2).reshape(size, size) if "covariance" in content else None
    coverage = _numbers(content["coverage"], 48).reshape(6, 8).astype(int) if "coverage" in content else None
    return Calibration(
        lens=make_lens(kind.name, distortion.tolist()),
        width_px=int(content["image_width"]),
        height_px=int(content["image_height"]),
        intrinsics_px=np.array([matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]]),
        rms_px=float(content.get("rms_px", content.get("avg_reprojection_error", np.nan))),
        covariance=np.full((size, size), np.nan) if covariance is None else covariance,
        image_names=(),
        image_rms_px=_numbers(content["image_rms_px"], None) if "image_rms_px" in content else np.empty(0),
        rejected=(),
        coverage=np.zeros((6, 8), int) if coverage is None else coverage,
        board=None,
    )


def _matrix(name: str, values: FloatArray) -> str:
    data = ", ".join(f"{float(value)!r}" for value in np.ravel(values))
    return (
        f"{name}: !!opencv-matrix\n   rows: {values.shape[0]}\n   cols: {values.shape[1]}\n"
        f"   dt: d\n   data: [ {data} ]"
    )


def _numbers(block: dict[str, Any], count: int | None) -> FloatArray:
    values = np.array([float(value) for value in block["data"]])
    if (count is not None and len(values) != count) or not np.isfinite(values).all():
        raise ValueError(f"a matrix of {len(values)} numbers, or one that is not finite")
    return values
