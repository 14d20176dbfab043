"""Calibration boards: printed pattern, and positions of its points.

chessboard     circles (asymmetric)      charuco
■ □ ■ □        ●   ●   ●                 ■ ▣ ■ ▣     ▣ a marker of the dictionary in a white square
□ ■ □ ■          ●   ●   ●               ▣ ■ ▣ ■
"""

from __future__ import annotations

from typing import Any, Literal

import numpy as np
from pydantic import model_validator
from pydantic_core import PydanticCustomError

from palpate.core import BoolArray, FloatArray, PalpateError, Spec, load_opencv, parameter

GROUP = "calibration code published by the group of Zaid et al. 2024"


class BoardSpec(Spec):
    """A calibration board; the default is the ChArUco board of the paper's group."""

    kind: Literal["chessboard", "circles", "symmetric-circles", "charuco"] = parameter(
        "charuco", unit="", meaning="pattern; circles are an asymmetric grid", source=GROUP
    )
    columns: int = parameter(
        11,
        unit="1",
        meaning="squares across; inner corners of a chessboard; circles of a row",
        source=GROUP,
        ge=3,
        le=60,
    )
    rows: int = parameter(
        8, unit="1", meaning="squares down; inner corners of a chessboard; rows of circles", source=GROUP, ge=3, le=60
    )
    square: float = parameter(
        29.0,
        unit="mm",
        meaning="side of a square; of circles half the distance in a row, or the distance of symmetric ones",
        source=GROUP,
        gt=0,
        le=500,
    )
    marker: float = parameter(21.5, unit="mm", meaning="side of a ChArUco marker", source=GROUP, gt=0, le=500)
    dictionary: str = parameter("DICT_4X4_100", unit="", meaning="dictionary of the ChArUco markers", source=GROUP)
    legacy: bool = parameter(
        False, unit="", meaning="whether a ChArUco board of an even number of rows has a marker in its first square"
    )

    @model_validator(mode="after")
    def _markers_fit(self) -> BoardSpec:
        if self.kind == "charuco" and self.marker >= self.square:
            raise PydanticCustomError(
                "board-marker-too-large",
                "marker {marker} mm does not fit into a square of {square} mm.",
                {"marker": self.marker, "square": self.square},
            )
        return self


BOARDS = {
    "charuco": BoardSpec(),
    "chessboard": BoardSpec(kind="chessboard", columns=9, rows=6, square=25.0),
    "circles": BoardSpec(kind="circles", columns=4, rows=11, square=20.0),
    "symmetric-circles": BoardSpec(kind="symmetric-circles", columns=7, rows=6, square=20.0),
}
"""Boards by name."""


class CalibrationSpec(Spec):
    """Settings of a camera calibration."""

    board: BoardSpec = BoardSpec()
    """The board in the images."""
    lens: Literal["pinhole", "fisheye"] = parameter("pinhole", unit="", meaning="model of the lens")
    fix_k3: bool = parameter(
        False, unit="", meaning="whether the sixth-order term is 0; few boards separate it from the fourth"
    )
    keep_outliers: bool = parameter(False, unit="", meaning="whether outlier images are kept")
    window_px: int | None = parameter(
        None, unit="px", meaning="half the window in which a chessboard's corner is refined", ge=1, le=50
    )
    min_images: int = parameter(4, unit="1", meaning="minimum number of images for a fit", ge=3, le=1000)


def read_board(text: str) -> BoardSpec:
    """Read a board from text: ``charuco``, ``chessboard:9x6:25``, ``charuco:11x8:29:21.5:DICT_4X4_100``.

    Raises
    ------
    PalpateError
        If the text does not describe a board.
    """
    kind, *parts = text.split(":")
    if kind not in BOARDS or len(parts) > 4:
        raise PalpateError(
            f"{text!r} is not a known board.",
            f"Choose one of {', '.join(BOARDS)}, optionally with :COLUMNSxROWS:SQUARE_MM.",
            code="board-unknown",
        )
    chosen: dict[str, Any] = BOARDS[kind].model_dump()
    try:
        if parts:
            chosen["columns"], chosen["rows"] = (int(word) for word in parts[0].lower().split("x"))
        chosen.update(zip(("square", "marker"), (float(word) for word in parts[1:3]), strict=False))
    except ValueError as error:
        raise PalpateError(
            f"{text!r} is not a board: {error}.", "Write it as charuco:11x8:29:21.5.", code="board-malformed"
        ) from error
    if len(parts) == 4:
        chosen["dictionary"] = parts[3]
    return BoardSpec(**chosen)


def board_points(board: BoardSpec) -> FloatArray:
    """Return the points (n, 3) mm of a board, z = 0: inner corners or centres of circles, row by row."""
    if board.kind == "circles":
        row, column = np.mgrid[: board.rows, : board.columns].reshape(2, -1)
        plane = np.stack([2 * column + row % 2, row], axis=-1)
    else:
        inner = 1 if board.kind == "charuco" else 0  # of a chessboard and a symmetric grid the points are counted
        row, column = np.mgrid[: board.rows - inner, : board.columns - inner].reshape(2, -1)
        plane = np.stack([column + inner, row + inner], axis=-1)
    return np.column_stack([plane * board.square, np.zeros(len(plane))])


def charuco_board(board: BoardSpec) -> Any:
    """Return OpenCV's description of a ChArUco board.

    Raises
    ------
    PalpateError
        If the dictionary is unknown or too small.
    """
    aruco = load_opencv().aruco
    if not board.dictionary.startswith("DICT_") or not hasattr(aruco, board.dictionary):
        raise PalpateError(
            f"Unknown dictionary {board.dictionary!r}.",
            "Choose one of OpenCV's, such as DICT_4X4_100.",
            code="board-dictionary-unknown",
        )
    dictionary = aruco.getPredefinedDictionary(getattr(aruco, board.dictionary))
    if board.columns * board.rows // 2 > len(dictionary.bytesList):
        raise PalpateError(
            f"{board.columns} × {board.rows} squares need {board.columns * board.rows // 2} markers, "
            f"{board.dictionary} has {len(dictionary.bytesList)}.",
            "Choose a larger dictionary.",
            code="board-dictionary-too-small",
        )
    made = aruco.CharucoBoard((board.columns, board.rows), board.square, board.marker, dictionary)
    made.setLegacyPattern(board.legacy)
    return made


def alternative_boards(board: BoardSpec) -> list[tuple[BoardSpec, str]]:
    """Return boards that a description often means instead, each with the sentence that reports it.

    These are the legacy ChArUco pattern (OpenCV before 4.6, calib.io), columns and rows exchanged, squares counted in
    place of inner corners or the reverse, and a circle grid of another kind.
    """
    found: list[tuple[BoardSpec, str]] = []
    step = {"chessboard": -1, "charuco": 1}.get(board.kind, 0)
    counted = {"chessboard": "inner corners", "charuco": "squares"}.get(board.kind, "circles")
    own = f"{board.columns} × {board.rows}"
    sizes = [(board.columns, board.rows, "")]
    for add in dict.fromkeys((0, step)):
        for columns, rows in ((board.columns + add, board.rows + add), (board.rows + add, board.columns + add)):
            why = (
                "columns and rows are exchanged"
                if not add
                else "squares were counted"
                if step < 0
                else "inner corners were counted"
            )
            if min(columns, rows) >= 3 and (columns, rows) not in [size[:2] for size in sizes]:
                sizes.append((columns, rows, f"{columns} × {rows} {counted} were found, not {own}: {why}."))
    kinds = {"circles": ("circles", "symmetric-circles"), "symmetric-circles": ("symmetric-circles", "circles")}
    legacies = (board.legacy, not board.legacy) if board.kind == "charuco" else (False,)
    for columns, rows, said in sizes:
        for kind in kinds.get(board.kind, (board.kind,)):
            for legacy in legacies:
                notes = [said] if said else []
                if kind != board.kind:
                    notes.append(f"The circles are {'a symmetric' if kind != 'circles' else 'an asymmetric'} grid.")
                if legacy and not board.legacy and rows % 2 == 0:
                    notes.append(
                        "The board has the legacy ChArUco pattern (OpenCV before 4.6, calib.io): a marker in its "
                        "first square."
                    )
                one = {"columns": columns, "rows": rows, "kind": kind, "legacy": legacy}
                if notes:
                    found.append((board.model_copy(update=one), " ".join(notes)))
    return found


def charuco_bits(board: BoardSpec) -> list[tuple[int, int, BoolArray]]:
    """Return column, row and (k, k) black cells, border included, of every marker of a ChArUco board."""
    aruco = load_opencv().aruco
    made = charuco_board(board)
    side = made.getDictionary().markerSize + 2
    found = []
    for number, corners in zip(np.ravel(made.getIds()), made.getObjPoints(), strict=True):
        middle = np.asarray(corners)[:, :2].mean(axis=0)
        column, row = (int(value // board.square) for value in middle)
        bits = aruco.generateImageMarker(made.getDictionary(), int(number), side)
        found.append((column, row, np.asarray(bits) < 128))
    return found
