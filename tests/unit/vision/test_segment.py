"""Moments of a blob that is cut out of an image of heights."""

import numpy as np
import pytest

from palpate.vision.segment import segment


@pytest.mark.parametrize(("across", "down"), [(5, 3), (3, 5), (4, 4)])
def test_a_rectangle_has_its_closed_form_moments(across: int, down: int) -> None:
    """A rectangle of a by b pixels has the variances a²/12 and b²/12."""
    height = np.zeros((24, 30), np.float32)
    height[9 : 9 + down, 12 : 12 + across] = 10.0
    found = segment(height, 4.0, 1.0, 0.5)
    assert found.area_px == pytest.approx([across * down])
    assert found.middle_px[0] == pytest.approx([12 + (across - 1) / 2, 9 + (down - 1) / 2])
    assert found.spread[0] == pytest.approx([across**2 / 12, 0.0, down**2 / 12])
    assert found.contrast == pytest.approx([10.0])
    assert not found.at_border.any()
    assert found.diameter_px == pytest.approx([np.sqrt(4 / np.pi * across * down)])
    assert found.roundness == pytest.approx([min(across, down) / max(across, down)])
    assert found.fullness == pytest.approx([3.0 / np.pi])


def test_a_diagonal_has_a_covariance_and_a_blob_at_the_border_is_marked() -> None:
    height = np.zeros((24, 30), np.float32)
    for place in range(4):
        height[8 + place, 10 + place : 12 + place] = 10.0
    height[20:24, 25:28] = 10.0
    found = segment(height, 4.0, 1.0, 0.5)
    x, y = np.array([10, 11, 11, 12, 12, 13, 13, 14]), np.array([8, 8, 9, 9, 10, 10, 11, 11])
    wanted = [x.var() + 1 / 12, np.mean((x - x.mean()) * (y - y.mean())), y.var() + 1 / 12]
    assert found.spread[0] == pytest.approx(wanted)
    assert found.at_border.tolist() == [False, True]
