"""Calibration of the lens of a camera from images of a board (Zhang 2000, by OpenCV).

An image is left out, with its reason, if the board is not found, its size differs from that of most images, or its
residual is more than 4 times the median of all images and more than 1 px; the rest is fitted again.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.camera.board import BoardSpec, CalibrationSpec, alternative_boards, board_points
from palpate.camera.calibration import Calibration
from palpate.camera.find_board import find_board
from palpate.camera.lens import Lens
from palpate.camera.lenses.brown import Brown
from palpate.camera.lenses.kannala_brandt import KannalaBrandt
from palpate.core import FloatArray, PalpateError, load_opencv

_CELLS = (6, 8)
"""Rows and columns of image parts whose coverage by corners is reported. By hand."""
_OUTLIER, _OUTLIER_PX = 4.0, 1.0
"""Maximum residual of an image over the median one, if more than these pixels. By hand."""
_FIRST_IMAGES = 8
"""Number of images in which boards other than the given one are tried. By hand."""


@dataclass(frozen=True, eq=False)
class _View:
    name: str
    points: FloatArray
    pixels: FloatArray
    size: tuple[int, int]


@dataclass(frozen=True, eq=False)
class _Found:
    intrinsics: FloatArray
    model: Lens
    covariance: FloatArray
    residuals: list[FloatArray]


def calibrate_camera(
    images: Iterable[tuple[str, NDArray[Any] | str]], spec: CalibrationSpec | None = None
) -> Calibration:
    """Calibrate a camera.

    Parameters
    ----------
    images
        Names and images of a board in different poses; instead of an image, the reason why it could not be read.
    spec
        Board and lens.

    Raises
    ------
    PalpateError
        If too few images show the board, or the fit fails.
    """
    spec = spec or CalibrationSpec()
    views, rejected, size, board, note = _find_views(images, spec)
    _refuse_few(views, rejected, spec)
    lens = _fit(views, size, spec)
    rms = [float(np.sqrt(np.mean((miss**2).sum(axis=1)))) for miss in lens.residuals]
    limit = max(_OUTLIER * float(np.median(rms)), _OUTLIER_PX)
    worse = [number for number, value in enumerate(rms) if value > limit and not spec.keep_outliers]
    if worse:
        reason = f"its points fit to {{:.2f}} px, more than {limit:.2f} px"
        rejected += [(views[number].name, reason.format(rms[number])) for number in worse]
        views = [view for number, view in enumerate(views) if number not in worse]
        _refuse_few(views, rejected, spec)
        lens = _fit(views, size, spec)
        rms = [float(np.sqrt(np.mean((miss**2).sum(axis=1)))) for miss in lens.residuals]
    return Calibration(
        lens=lens.model,
        width_px=size[0],
        height_px=size[1],
        intrinsics_px=lens.intrinsics,
        rms_px=float(np.sqrt(np.mean((np.concatenate(lens.residuals) ** 2).sum(axis=1)))),
        covariance=lens.covariance,
        image_names=tuple(view.name for view in views),
        image_rms_px=np.array(rms),
        rejected=tuple(rejected),
        coverage=_count_cells(np.concatenate([view.pixels for view in views]), size),
        board=board,
        note=note,
    )


def _find_views(
    images: Iterable[tuple[str, NDArray[Any] | str]], spec: CalibrationSpec
) -> tuple[list[_View], list[tuple[str, str]], tuple[int, int], BoardSpec, str]:
    """Return views, rejected images, image size, the board, and a sentence if it is not the one given.

    Other boards are tried only until the given one is found in an image, all of them in the first images.
    """
    given = _Candidate(spec.board)
    others = [_Candidate(board, note) for board, note in alternative_boards(spec.board)]
    for number, (name, image) in enumerate(images):
        given.look(name, image, spec.window_px)
        if given.views:
            others = []
        elif number >= _FIRST_IMAGES:
            others = [one for one in others if one.views]
        for other in others:
            other.look(name, image, spec.window_px)
    best = max([given, *others], key=lambda one: len(one.views))
    sizes = Counter(view.size for view in best.views)
    size = max(sizes, key=lambda one: sizes[one], default=(0, 0))
    reason = f"it has {{}} × {{}} px, most images {size[0]} × {size[1]}"
    best.rejected += [(view.name, reason.format(*view.size)) for view in best.views if view.size != size]
    return [view for view in best.views if view.size == size], best.rejected, size, best.board, best.note


@dataclass
class _Candidate:
    """A candidate board and its detections."""

    board: BoardSpec
    note: str = ""
    views: list[_View] = field(default_factory=list)
    rejected: list[tuple[str, str]] = field(default_factory=list)

    def look(self, name: str, image: NDArray[Any] | str, window_px: int | None) -> None:
        """Find the board in one more image."""
        found = image if isinstance(image, str) else find_board(image, self.board, window_px)
        if isinstance(image, str) or isinstance(found, str):
            self.rejected.append((name, str(found)))
            return
        size = (image.shape[1], image.shape[0])
        self.views.append(_View(name, board_points(self.board)[found[0]], found[1], size))


def _refuse_few(views: list[_View], rejected: list[tuple[str, str]], spec: CalibrationSpec) -> None:
    if len(views) < spec.min_images:
        first = f" {rejected[0][0]}: {rejected[0][1]}." if rejected else ""
        raise PalpateError(
            f"{len(views)} of {len(views) + len(rejected)} images can be used, {spec.min_images} are needed.{first}",
            "Check the kind and counts of the board, and the focus; take ten or more images, tilted to all sides.",
            code="calibration-few-images",
        )


def _fit(views: list[_View], size: tuple[int, int], spec: CalibrationSpec) -> _Found:
    cv2 = load_opencv()
    points = [view.points.astype(np.float32).reshape(-1, 1, 3) for view in views]
    pixels = [view.pixels.astype(np.float32).reshape(-1, 1, 2) for view in views]
    try:
        if spec.lens == "fisheye":
            return _fit_fisheye(points, pixels, size)
        flags = cv2.CALIB_FIX_K3 if spec.fix_k3 else 0
        _, matrix, distortion, turns, shifts = cv2.calibrateCamera(points, pixels, size, None, None, flags=flags)
    except cv2.error as error:
        raise PalpateError(
            f"The calibration failed: {str(error).strip().splitlines()[-1]}.",
            "Take images tilted to all sides.",
            code="calibration-failed",
        ) from error
    distortion = np.ravel(distortion)[:5]
    projected, slopes = [], []
    for point, turn, shift in zip(points, turns, shifts, strict=True):
        made, slope = cv2.projectPoints(point, turn, shift, matrix, distortion)
        projected.append(np.asarray(made, float).reshape(-1, 2))
        slopes.append(np.asarray(slope, float))
    residuals = [np.asarray(made - seen.reshape(-1, 2), float) for made, seen in zip(projected, pixels, strict=True)]
    intrinsics = np.array([matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]], float)
    covariance = _covariance(slopes, residuals, 8 if spec.fix_k3 else 9)
    return _Found(intrinsics, Brown(*distortion.tolist()), covariance, residuals)


def _fit_fisheye(points: list[Any], pixels: list[Any], size: tuple[int, int]) -> _Found:
    cv2 = load_opencv()
    # OpenCV 5 moved the flags out of cv2.fisheye
    door = cv2.fisheye if hasattr(cv2.fisheye, "CALIB_FIX_SKEW") else cv2
    flags = door.CALIB_RECOMPUTE_EXTRINSIC | door.CALIB_FIX_SKEW | door.CALIB_USE_INTRINSIC_GUESS
    points = [point.astype(np.float64).reshape(1, -1, 3) for point in points]
    pixels = [pixel.astype(np.float64).reshape(1, -1, 2) for pixel in pixels]
    # OpenCV's guess covers a half space; half the width is the focal length of a common lens
    matrix = np.array([[size[0] / 2.0, 0, size[0] / 2.0], [0, size[0] / 2.0, size[1] / 2.0], [0, 0, 1.0]])
    _, matrix, distortion, turns, shifts = cv2.fisheye.calibrate(
        points, pixels, size, matrix, np.zeros((4, 1)), flags=flags
    )
    residuals = []
    for point, pixel, turn, shift in zip(points, pixels, turns, shifts, strict=True):
        made, _ = cv2.fisheye.projectPoints(point, turn, shift, matrix, distortion)
        residuals.append(np.asarray(made, float).reshape(-1, 2) - pixel.reshape(-1, 2))
    intrinsics = np.array([matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2]], float)
    return _Found(intrinsics, KannalaBrandt(*np.ravel(distortion).tolist()), np.full((8, 8), np.nan), residuals)


def _covariance(slopes: list[FloatArray], residuals: list[FloatArray], lens: int) -> FloatArray:
    """Return σ² (JᵀJ)⁻¹ of the lens, poses eliminated; the first six of OpenCV's columns are the pose."""
    normal = np.zeros((lens, lens))
    for slope in slopes:
        pose, own = slope[:, :6], slope[:, 6 : 6 + lens]
        cross = pose.T @ own
        normal += own.T @ own - cross.T @ np.linalg.solve(pose.T @ pose, cross)
    misses = np.concatenate(residuals)
    free = misses.size - lens - 6 * len(slopes)
    variance = float((misses**2).sum()) / max(free, 1)
    scale = np.sqrt(np.diag(normal))
    full = np.zeros((9, 9))
    full[:lens, :lens] = variance * np.linalg.pinv(normal / np.outer(scale, scale)) / np.outer(scale, scale)
    return full


def _count_cells(pixels: FloatArray, size: tuple[int, int]) -> NDArray[np.intp]:
    row = np.clip((pixels[:, 1] / size[1] * _CELLS[0]).astype(int), 0, _CELLS[0] - 1)
    column = np.clip((pixels[:, 0] / size[0] * _CELLS[1]).astype(int), 0, _CELLS[1] - 1)
    counts = np.zeros(_CELLS, np.intp)
    np.add.at(counts, (row, column), 1)
    return counts
