"""A printed board seen by a known camera: only for tests."""

from functools import cache

import cv2
import numpy as np

from palpate.camera.board import board_points
from palpate.camera.draw_board import _DOT, _MARGIN, _black_squares, board_size
from palpate.core import generator

SIZE = (640, 480)
MATRIX = np.array([[520.0, 0, 331.0], [0, 523.0, 236.0], [0, 0, 1]])
LENS = np.array([-0.21, 0.06, 0.0008, -0.0005, 0.0])
_PX_PER_MM = 4.0


@cache
def _undistorted():
    """Samples a pixel along an axis, and the places (n, 2) of all samples in the plane at distance 1."""
    fine = 3
    u, v = np.meshgrid((np.arange(SIZE[0] * fine) + 0.5) / fine - 0.5, (np.arange(SIZE[1] * fine) + 0.5) / fine - 0.5)
    return fine, cv2.undistortPoints(np.stack([u, v], -1).reshape(-1, 1, 2), MATRIX, LENS).reshape(-1, 2)


def draw_board(board, px_per_mm):
    """Draw the printed sheet as an image (h, w) of 0 and 255.

    The board's point (0, 0) is one square inside the top left corner of the sheet.
    """
    width, height = board_size(board)
    rows, columns = round(height * px_per_mm), round(width * px_per_mm)
    x = (np.arange(columns) + 0.5) / px_per_mm - _MARGIN * board.square
    y = (np.arange(rows) + 0.5) / px_per_mm - _MARGIN * board.square
    sheet = np.full((rows, columns), 255, np.uint8)
    if board.kind.endswith("circles"):
        for cx, cy, _ in board_points(board):
            dx, dy = x[None] - cx - board.square / 2, y[:, None] - cy - board.square / 2
            sheet[dx**2 + dy**2 <= (_DOT * board.square) ** 2] = 0
        return sheet
    for left, top, side in _black_squares(board):
        inside_x = (x >= left) & (x < left + side)
        inside_y = (y >= top) & (y < top + side)
        sheet[np.ix_(inside_y, inside_x)] = 0
    return sheet


def photograph(board, rotation, shift, noise, rng):
    """The sheet warped into the image of a lens, four samples a pixel, blurred and noisy."""
    sheet = cv2.GaussianBlur(draw_board(board, _PX_PER_MM), (0, 0), 1.2)
    fine, plane = _undistorted()
    rays = np.column_stack([plane, np.ones(len(plane))]) @ rotation
    origin = -rotation.T @ shift
    points = origin[:2] - (origin[2] / rays[:, 2])[:, None] * rays[:, :2]
    place = ((points + board.square) * _PX_PER_MM - 0.5).astype(np.float32)
    x, y = place.T.reshape(2, SIZE[1] * fine, SIZE[0] * fine)
    image = cv2.remap(sheet, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=150)
    image = cv2.GaussianBlur(cv2.resize(image, SIZE, interpolation=cv2.INTER_AREA), (0, 0), 0.7)
    return np.clip(np.rint(30 + 0.75 * image + rng.normal(0, noise, image.shape)), 0, 255).astype(np.uint8)


def views(board, count=16, noise=1.5):
    """Names and images of the board, tilted by 20 to 40° to all sides and moved about the image."""
    rng = generator(4, "views", board.kind)
    width, height = board_size(board)
    made = []
    for number in range(count):
        azimuth = 2 * np.pi * number / count + rng.uniform(-0.2, 0.2)
        tilt = np.radians(rng.uniform(20, 40))
        rotation, _ = cv2.Rodrigues(tilt * np.array([np.cos(azimuth), np.sin(azimuth), rng.uniform(-0.3, 0.3)]))
        middle = np.array([width / 2 - board.square, height / 2 - board.square, 0.0])
        distance = 1.3 * max(width / SIZE[0], height / SIZE[1]) * MATRIX[0, 0]
        aside = rng.uniform(-0.08, 0.08, 2) * distance
        shift = np.array([*aside, distance]) - rotation @ middle
        made.append((f"view {number}", photograph(board, rotation, shift, noise, rng)))
    return made
