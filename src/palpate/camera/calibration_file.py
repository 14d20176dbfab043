"""Calibrations as YAML that OpenCV's FileStorage and ROS's camera_info both read.

ROS requires ``camera_matrix``, ``distortion_coefficients``, ``rectification_matrix`` and ``projection_matrix`` with
rows, cols and data; OpenCV requires the first line and the mark ``!!opencv-matrix``, which ROS ignores.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from palpate.camera.calibration import Calibration
from palpate.camera.camera_formats import flat, read_camera_file
from palpate.camera.lens import LENSES, Lens, lens_from_model, make_lens
from palpate.camera.lenses.brown import Brown
from palpate.core import FloatArray, PalpateError

_PINHOLE_COUNTS = (4, 5, 8, 12, 14)
"""Numbers of coefficients of OpenCV's pinhole models."""
_TANGENTIAL = 0.01
"""Maximum third and fourth of four coefficients that count as k1, k2, p1, p2 if a file names no model.

Tangential coefficients of a mounted lens are of the order 0.001 (0.0007 and 0.0004 of the DAVIS in the tests), those
of a fisheye of the order 0.01 to 0.1.
"""


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
    """Read a calibration written by palpate, OpenCV, ROS or Kalibr (`palpate.camera.camera_formats`).

    Raises
    ------
    PalpateError
        If the file is not a calibration, or its coefficients are not those of the lens model that it names.
    """
    try:
        return _calibration(path.name, read_camera_file(path))
    except PalpateError:
        raise
    except Exception as error:  # a damaged file ends the parsers by errors of every kind
        raise PalpateError(
            f"{path.name} is not a calibration: {_first_line(error)}.",
            "Give YAML, XML, JSON or NPZ of OpenCV, YAML, ost.ini or `topic echo` of ROS, or a file of Kalibr, "
            "MATLAB (.mat) or COLMAP (cameras.txt).",
            code="calibration-file-unreadable",
        ) from error


def _first_line(error: Exception) -> str:
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return (lines[0] if lines else type(error).__name__).rstrip(".")[:160]


def _find_lens(name: str, content: dict[str, Any]) -> Lens:
    """Return the lens of OpenCV's coefficients: 4 to 14 of a pinhole, 4 of a fisheye.

    A file without a model is of a pinhole camera. Four coefficients may also be those of a fisheye, unless the third
    and fourth are as small as tangential coefficients.
    """
    values = _numbers(content.get("distortion_coefficients", []), None)
    named = content.get("distortion_model")
    if not len(values):
        raise PalpateError(
            f"{name} states no distortion of the lens.",
            "Add a line `distortion_coefficients: [0, 0, 0, 0, 0]` for a lens without distortion.",
            code="lens-coefficient-count",
        )
    kind = lens_from_model("plumb_bob" if named in (None, "") or not values.any() else str(named))
    if not named and len(values) == 4 and np.abs(values[2:]).max() > _TANGENTIAL:
        raise PalpateError(
            f"{name} has 4 coefficients and names no lens model: they may be k1, k2, p1, p2 or those of a fisheye.",
            "Add a line `distortion_model: plumb_bob` or `distortion_model: equidistant`.",
            code="lens-model-ambiguous",
        )
    if kind is not None and kind.model in ("plumb_bob", "rational_polynomial"):
        if len(values) == 14 and values[12:].any():
            raise PalpateError(
                f"{name} has the tilted sensor model (τx {values[12]:g}, τy {values[13]:g}), which palpate does not "
                "support.",
                "Calibrate without CALIB_TILTED_MODEL.",
                code="lens-model-unknown",
            )
        if len(values) in _PINHOLE_COUNTS:
            values = np.pad(values, (0, 14 - len(values)))[:12]
            kind, values = (lens_from_model("rational"), values) if values[5:].any() else (Brown, values[:5])
    elif kind is not None and not values[len(kind.parameters()) :].any():
        values = values[: len(kind.parameters())]
    if kind is None or len(values) != len(kind.parameters()):
        known = (f"{lens.model or key} takes {', '.join(lens.parameters())}" for key, lens in LENSES.available())
        raise PalpateError(
            f"{name} has {len(values)} coefficients for the lens model {named}.",
            f"Give the coefficients of one model: {'; '.join(known)}.",
            code="lens-coefficient-count",
        )
    return make_lens(kind.name, values.tolist())


def _calibration(name: str, content: dict[str, Any]) -> Calibration:
    matrix = _numbers(content["camera_matrix"], 9).reshape(3, 3)
    if matrix[2, :2].all() and not matrix[:2, 2].any():  # by columns, as MATLAB and Open3D write it
        matrix = matrix.T
    lens = _find_lens(name, content)
    focal, width, height = matrix[[0, 1], [0, 1]], float(content["image_width"]), float(content["image_height"])
    if not (focal > 0.0).all() or width < 1.0 or height < 1.0:
        raise PalpateError(
            f"{name} has focal lengths {focal[0]:g} and {focal[1]:g} px for an image of {width:g} × {height:g} px.",
            "ROS writes zeros for a camera that is not calibrated: calibrate it.",
            code="calibration-file-unreadable",
        )
    if not (0.0 < matrix[0, 2] < width and 0.0 < matrix[1, 2] < height):
        raise PalpateError(
            f"{name} has its centre at {matrix[0, 2]:g}, {matrix[1, 2]:g} px, outside of {width:g} × {height:g} px.",
            "Check that centre and size are those of one camera.",
            code="calibration-file-unreadable",
        )
    size = 4 + len(lens.coefficients)
    covariance = _numbers(content["covariance"], size**2).reshape(size, size) if "covariance" in content else None
    coverage = _numbers(content["coverage"], 48).reshape(6, 8).astype(int) if "coverage" in content else None
    return Calibration(
        lens=lens,
        width_px=int(width),
        height_px=int(height),
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


def _numbers(block: Any, count: int | None) -> FloatArray:
    values = np.array([float(value) for value in flat(block)])
    if (count is not None and len(values) != count) or not np.isfinite(values).all():
        raise ValueError(f"a matrix of {len(values)} numbers, or one that is not finite")
    return values
