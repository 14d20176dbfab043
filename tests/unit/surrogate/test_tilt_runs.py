"""Interpolation between tilts, by value or by value and slope."""

import numpy as np
import pytest

from palpate.surrogate.tilt_runs import cut_into_runs

TILTS = np.array([0.0, 6.0, 12.0])
BETWEEN = np.array([1.0, 5.0, 7.0, 11.0])


def quartic(tilt: np.ndarray) -> np.ndarray:
    return 1.0 - 0.03 * tilt**2 + 2e-4 * tilt**4


def slope(tilt: np.ndarray) -> np.ndarray:
    return -0.06 * tilt + 8e-4 * tilt**3


def error(slopes: np.ndarray | None) -> float:
    values = quartic(TILTS)[None, :, None]
    runs = cut_into_runs(TILTS, np.full((1, 3), "flat"), ["depth reached"] * 3, values, values, slopes)
    ((_, found),) = runs.read(BETWEEN, 0)
    return float(np.abs(found[:, 0] - quartic(BETWEEN)).max())


def test_slopes_make_three_tilts_as_good_as_hermites_bound() -> None:
    """Error of a cubic with slopes: h⁴/384 max|f⁗|, with h = 6 and f⁗ = 4.8e-3."""
    assert error(slope(TILTS)[None, :, None]) <= 6.0**4 / 384 * 24 * 2e-4 * (1 + 1e-9)
    assert error(None) > 2 * error(slope(TILTS)[None, :, None])


def test_a_slope_that_is_not_finite_leaves_the_spline_through_values() -> None:
    slopes = slope(TILTS)[None, :, None].copy()
    slopes[0, 1] = np.nan
    assert error(slopes) == pytest.approx(error(None))
