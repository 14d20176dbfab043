"""Boards that are described wrongly, as people describe them: found by themselves, and the difference is reported."""

import numpy as np
import pytest
from synthetic_board import MATRIX, views

from palpate.camera import CalibrationSpec, calibrate_camera, read_board
from palpate.camera.board import BoardSpec

CHARUCO = BoardSpec(columns=7, rows=6, square=29.0, marker=21.5)
LEGACY = CHARUCO.model_copy(update={"legacy": True})
CHESSBOARD = BoardSpec(kind="chessboard", columns=9, rows=6, square=25.0)
SYMMETRIC = BoardSpec(kind="symmetric-circles", columns=7, rows=6, square=20.0)
CASES = {
    "legacy pattern": (LEGACY, "charuco:7x6:29:21.5", "legacy"),
    "counts exchanged": (CHARUCO, "charuco:6x7:29:21.5", "7 × 6 squares were found, not 6 × 7"),
    "corners of a ChArUco board": (CHARUCO, "charuco:6x5:29:21.5", "7 × 6 squares were found, not 6 × 5"),
    "legacy pattern and corners": (LEGACY, "charuco:5x6:29:21.5", "legacy"),
    "squares of a chessboard": (CHESSBOARD, "chessboard:10x7:25", "9 × 6 inner corners were found, not 10 × 7"),
    "circles in rows": (SYMMETRIC, "circles:7x6:20", "symmetric grid"),
    "as it is": (CHARUCO, "charuco:7x6:29:21.5", ""),
    "symmetric circles": (SYMMETRIC, "symmetric-circles:7x6:20", ""),
}


@pytest.mark.parametrize("name", CASES)
def test_the_board_in_the_images_is_recognised_and_reported(name: str) -> None:
    printed, told, said = CASES[name]
    found = calibrate_camera(views(printed, 4), CalibrationSpec(board=read_board(told), fix_k3=True))
    assert len(found.image_names) == 4
    assert said in found.note
    assert bool(found.note) == bool(said)
    assert found.intrinsics_px == pytest.approx(MATRIX[[0, 1, 0, 1], [0, 1, 2, 2]], rel=0.03)
    assert np.isfinite(found.rms_px)
    assert found.rms_px < 0.3
