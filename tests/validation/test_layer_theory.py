"""The theory of pressed layers, by its limits and by what others printed."""

import numpy as np
import pytest

from validation.layer_theory import ball_on_layer, bar_on_layer

RADIUS, MODULUS = 100.0, 0.3


def test_far_from_the_window_it_is_hertz() -> None:
    """Hertz 1882; Johnson 1985, sections 4.1 and 4.2: F = 16/9 E sqrt(R) d^1.5, a² = R d; F = pi E* a² / 4R."""
    depth, force = ball_on_layer(1.0, 2000.0, RADIUS, MODULUS)
    assert depth == pytest.approx(1.0 / RADIUS, rel=1e-3)
    assert force == pytest.approx(16 / 9 * 3 * MODULUS * np.sqrt(RADIUS) * depth**1.5, rel=2e-3)
    _, force = bar_on_layer(1.0, 2000.0, RADIUS, MODULUS)
    assert force == pytest.approx(np.pi * 4 * MODULUS / (4 * RADIUS), rel=1e-4)


@pytest.mark.parametrize("thickness", [20.0, 8.0, 4.0, 3.0])
def test_a_ball_on_a_layer_is_as_printed(thickness: float) -> None:
    """Garcia & Garcia 2018, Biophys. J. 114, 2923: a polynomial of sqrt(R d)/h for an incompressible bonded layer."""
    depth, force = ball_on_layer(2.0, thickness, RADIUS, MODULUS)
    x = np.sqrt(RADIUS * depth) / thickness
    hertz = 16 / 9 * 3 * MODULUS * np.sqrt(RADIUS) * depth**1.5
    assert force / hertz == pytest.approx(np.polyval([0.755, 1.469, 1.497, 1.133, 1.0], x), rel=0.015)


def test_a_bar_on_a_thin_layer_squeezes_it_out() -> None:
    """As a film: h³/(3 mu) p'' = -(d - x²/2R), so that d = a²/6R where the pressure ends smoothly; reached slowly."""
    depths = [bar_on_layer(1.0, thickness, RADIUS, MODULUS)[0] * 6 * RADIUS for thickness in (0.5, 0.25, 0.125)]
    assert depths[0] > depths[1] > depths[2] > 1.0
    to_none = (8 * depths[2] - 6 * depths[1] + depths[0]) / 3  # by a parabola over the thickness
    assert to_none == pytest.approx(1.0, abs=0.03)
