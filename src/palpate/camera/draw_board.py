"""Boards for printing: a PDF in true size."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from palpate.camera.board import BoardSpec, board_points, charuco_bits

_MARGIN = 1.0
"""White margin around the pattern, in squares."""
_MM_PER_INCH = 25.4
"""Millimetres an inch."""
_DOT = 0.35
"""Radius of a circle over the distance of two rows."""


def board_size(board: BoardSpec) -> tuple[float, float]:
    """Return width and height of the printed sheet in mm, white margin included."""
    columns, rows = _cells(board)
    return (columns + 2 * _MARGIN) * board.square, (rows + 2 * _MARGIN) * board.square


def write_board(path: Path, board: BoardSpec) -> None:
    """Write the board as a PDF in true size.

    Print it at 100 %, glue it to a flat plate, and measure a square.
    """
    from matplotlib.backends.backend_pdf import FigureCanvasPdf
    from matplotlib.figure import Figure
    from matplotlib.patches import Circle, Rectangle

    width, height = board_size(board)
    figure = Figure(figsize=(width / _MM_PER_INCH, height / _MM_PER_INCH))
    FigureCanvasPdf(figure)
    axes = figure.add_axes((0, 0, 1, 1))
    shift = -_MARGIN * board.square
    axes.set_xlim(shift, width + shift)
    axes.set_ylim(height + shift, shift)
    axes.axis("off")
    if board.kind.endswith("circles"):
        for x, y, _ in board_points(board) + board.square / 2:
            axes.add_patch(Circle((x, y), _DOT * board.square, color="black", lw=0))
    else:
        for left, top, side in _black_squares(board):
            axes.add_patch(Rectangle((left, top), side, side, color="black", lw=0))
    axes.text(shift / 2, shift / 2, f"{board.kind} {board.columns} x {board.rows}, {board.square:g} mm", fontsize=6)
    figure.savefig(path, metadata={"CreationDate": None})


def _cells(board: BoardSpec) -> tuple[int, int]:
    if board.kind == "circles":
        return 2 * board.columns, board.rows
    more = 1 if board.kind == "chessboard" else 0
    return board.columns + more, board.rows + more


def _black_squares(board: BoardSpec) -> list[tuple[float, float, float]]:
    """Return left, top and side of all black squares, mm; a chessboard's first inner corner is (0, 0)."""
    columns, rows = _cells(board)
    shift = board.square if board.kind == "chessboard" else 0.0
    pairs = [(column, row) for row in range(rows) for column in range(columns)]
    if board.kind == "chessboard":
        return [
            (c * board.square - shift, r * board.square - shift, board.square) for c, r in pairs if (c + r) % 2 == 0
        ]
    squares = []
    taken = set()
    margin = (board.square - board.marker) / 2.0
    for column, row, bits in charuco_bits(board):
        taken.add((column, row))
        side = board.marker / len(bits)
        left, top = column * board.square + margin, row * board.square + margin
        squares += [(left + c * side, top + r * side, side) for r, c in np.argwhere(bits)]
    squares += [(c * board.square, r * board.square, board.square) for c, r in pairs if (c, r) not in taken]
    return squares
