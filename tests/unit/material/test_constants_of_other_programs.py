"""Constants convert to and from other programs: the stress by their formulas is that of the law."""

import numpy as np
import pytest

from errors import refused
from palpate.material import Mode, get_material, trace_curve

STRETCH = np.linspace(0.6, 2.5, 20)


def nominal(text: str) -> np.ndarray:
    return trace_curve(get_material(text), Mode.UNIAXIAL, STRETCH).nominal


def test_ogden_of_abaqus_and_calculix_has_mu_alpha_over_two() -> None:
    pairs = ((0.02, 1.8), (0.0006, 5.0))
    abaqus = [(mu * alpha / 2, alpha) for mu, alpha in pairs]  # W = sum 2 mu_k / alpha_k^2 (...), Abaqus theory 4.6.1
    stress = sum(2 * mu / alpha * (STRETCH ** (alpha - 1) - STRETCH ** (-alpha / 2 - 1)) for mu, alpha in abaqus)
    numbers = ",".join(f"{value:.12g}" for pair in pairs for value in pair)
    for name in ("ogden", "ogden-2"):
        assert nominal(f"{name}:{numbers}") == pytest.approx(stress, rel=1e-9)


def test_ogden_of_ansys_is_the_same() -> None:
    stress = 0.02 * (STRETCH**0.8 - STRETCH ** (-1.9))  # W = sum mu_k / alpha_k (...)
    assert nominal("ogden-1:0.02,1.8") == pytest.approx(stress, rel=1e-9)


def test_yeoh_is_the_same() -> None:
    first = STRETCH**2 + 2 / STRETCH - 3
    stress = 2 * (STRETCH - STRETCH**-2) * (0.018 - 2 * 0.0002 * first + 3 * 0.00003 * first**2)
    assert nominal("yeoh:0.018,-0.0002,0.00003") == pytest.approx(stress, rel=1e-9)


def test_arruda_boyce_has_the_factor_of_the_series() -> None:
    mu, lm, first = 0.03, 3.0, STRETCH**2 + 2 / STRETCH
    series = (1 / 2, 1 / 20, 11 / 1050, 19 / 7000, 519 / 673750)
    slope = sum(c * (i + 1) * first**i / lm ** (2 * i) for i, c in enumerate(series))
    assert nominal(f"arruda-boyce:{mu},{lm}") == pytest.approx(2 * mu * slope * (STRETCH - STRETCH**-2), rel=1e-9)
    modulus = get_material(f"arruda-boyce:{mu},{lm}").law.shear_modulus
    assert modulus == pytest.approx(mu * (1 + 3 / (5 * lm**2) + 99 / (175 * lm**4)), rel=2e-3)


def test_a_model_with_too_few_constants_is_refused() -> None:
    with refused("constants-count-wrong", "4", "2"):
        get_material("ogden-2:0.02,1.8")
