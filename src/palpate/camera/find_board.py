"""Detection of the points of a board in an image."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from palpate.camera.board import BoardSpec, board_points, charuco_board
from palpate.core import FloatArray, load_opencv

LEAST_POINTS = 8
"""Minimum number of points in an image; a homography alone requires four. By hand."""
_LARGEST_WINDOW_PX = 11
"""Maximum half side of a corner's window; a third of the spacing if that is less. By hand."""
_OFF_GRID, _ON_GRID = 0.3, 0.6
"""Maximum distance from a flat grid over that of corners; minimum share within it. By hand."""


def find_board(
    image: NDArray[Any], board: BoardSpec, window_px: int | None = None
) -> tuple[NDArray[np.intp], FloatArray] | str:
    """Find the board's points in an image.

    Parameters
    ----------
    image
        (h, w) or (h, w, 3).
    board
        The board.
    window_px
        Half the window in which a chessboard's corner is refined; by default a third of the squares and at most 11.

    Returns
    -------
    tuple or str
        Indices (n,) of the points (see `board_points`) and their pixels (n, 2); or the reason of a failure.
    """
    cv2 = load_opencv()
    grey = image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    if grey.dtype != np.uint8:
        low, high = float(grey.min()), float(grey.max())
        grey = np.rint((grey - low) * (255.0 / max(high - low, 1e-9))).astype(np.uint8)
    if min(grey.shape) < 32:
        return f"the image has only {grey.shape[1]} × {grey.shape[0]} px"
    find = {"chessboard": _find_chessboard, "charuco": _find_charuco}.get(board.kind, _find_circles)
    return find(grey, board, window_px)


def _find_chessboard(
    grey: NDArray[np.uint8], board: BoardSpec, window_px: int | None
) -> tuple[NDArray[np.intp], FloatArray] | str:
    cv2 = load_opencv()
    found, corners = cv2.findChessboardCorners(grey, (board.columns, board.rows), None)
    if not found:
        return f"no chessboard of {board.columns} × {board.rows} inner corners was found"
    pixels = np.asarray(corners, np.float32).reshape(-1, 2)
    if window_px is None:
        spacing = float(cKDTree(pixels).query(pixels, 2)[0][:, 1].min())
        window_px = int(np.clip(spacing / 3.0, 2, _LARGEST_WINDOW_PX))
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 30, 0.001)
    fine = cv2.cornerSubPix(grey, pixels.reshape(-1, 1, 2), (window_px, window_px), (-1, -1), stop)
    return np.arange(len(pixels)), np.asarray(fine, float).reshape(-1, 2)


def _find_circles(
    grey: NDArray[np.uint8], board: BoardSpec, _: int | None
) -> tuple[NDArray[np.intp], FloatArray] | str:
    cv2 = load_opencv()
    size = (board.columns, board.rows)
    spec = cv2.SimpleBlobDetector_Params()
    spec.minArea, spec.maxArea = 12.0, float(grey.size) / 40.0
    spec.minDistBetweenBlobs, spec.minThreshold, spec.thresholdStep = 3.0, 10.0, 5.0
    blobs = cv2.SimpleBlobDetector_create(spec)
    grid = cv2.CALIB_CB_ASYMMETRIC_GRID if board.kind == "circles" else cv2.CALIB_CB_SYMMETRIC_GRID
    for flags in (grid, grid | cv2.CALIB_CB_CLUSTERING):
        found, centres = cv2.findCirclesGrid(grey, size, flags=flags, blobDetector=blobs)
        if found:
            return np.arange(board.columns * board.rows), np.asarray(centres, float).reshape(-1, 2)
    return f"no grid of {board.rows} rows of {board.columns} circles was found"


def _find_charuco(
    grey: NDArray[np.uint8], board: BoardSpec, _: int | None
) -> tuple[NDArray[np.intp], FloatArray] | str:
    cv2 = load_opencv()
    spec = cv2.aruco.DetectorParameters()
    spec.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    detector = cv2.aruco.CharucoDetector(charuco_board(board), detectorParams=spec)
    corners, numbers, _, markers = detector.detectBoard(grey)
    count = 0 if numbers is None else len(numbers)
    if count < LEAST_POINTS:
        seen = 0 if markers is None else len(markers)
        return (
            f"{count} corners and {seen} markers of the ChArUco board were found, {LEAST_POINTS} corners are needed"
        )
    chosen = np.ravel(numbers).astype(np.intp)
    points = board_points(board)[chosen, :2]
    if np.linalg.matrix_rank(points - points.mean(axis=0), tol=1e-6) < 2:
        return f"the {count} corners found lie on one line"
    pixels = np.asarray(corners, float).reshape(-1, 2)
    spacing = float(np.median(cKDTree(pixels).query(pixels, 2)[0][:, 1]))
    _, fits = cv2.findHomography(points, pixels, cv2.RANSAC, max(_OFF_GRID * spacing, 1.0))
    if fits is None or np.mean(fits) < _ON_GRID:
        return f"the {count} corners found do not match the grid of this board"
    return chosen, pixels
