"""Every law: stress is the slope of energy, the tangent the slope of stress, frames do not matter."""

import numpy as np
import pytest

from palpate.core import PalpateError
from palpate.material import Material, Mode, get_material, list_materials, material_from_data, trace_curve

LAWS = [
    "zaid_2024_ecoflex_00_30",
    "neo-hooke:0.0141",
    "mooney-rivlin:0.1,0.05",
    "ogden:0.63,1.3,0.0012,5,-0.01,-2",
    "yeoh:0.1,-0.01,0.001",
]
VOIGT = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)]


def tensor(voigt: np.ndarray) -> np.ndarray:
    xx, yy, zz, xy, yz, zx = np.moveaxis(voigt, -1, 0)
    return np.stack([np.stack([xx, xy, zx], -1), np.stack([xy, yy, yz], -1), np.stack([zx, yz, zz], -1)], -2)


def random_states(count: int, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    F = np.eye(3) + 0.25 * rng.normal(size=(4 * count, 3, 3))
    return F[np.linalg.det(F) > 0.3][:count]


def random_rotation(seed: int) -> np.ndarray:
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


@pytest.fixture(params=LAWS)
def material(request: pytest.FixtureRequest) -> Material:
    return get_material(request.param)


def test_stress_is_the_slope_of_energy_and_the_tangent_that_of_stress(material: Material) -> None:
    F, step = random_states(200), 1e-5
    _, tau, c = material.evaluate(F)
    for q, (k, l) in enumerate(VOIGT):
        d = np.zeros((3, 3))
        d[k, l] += 0.5
        d[l, k] += 0.5
        ahead, behind = material.evaluate(F + step * d @ F), material.evaluate(F - step * d @ F)
        slope = (ahead[0] - behind[0]) / (2 * step)
        assert slope == pytest.approx(tau[:, q], abs=1e-7 * np.abs(tau).max())
        rate = tensor((ahead[1] - behind[1]) / (2 * step)) - d @ tensor(tau) - tensor(tau) @ d
        assert rate == pytest.approx(tensor(c[:, :, q]), abs=1e-7 * np.abs(c).max())
    assert c == pytest.approx(np.swapaxes(c, 1, 2), abs=1e-12 * np.abs(c).max())


def test_energy_and_stress_do_not_depend_on_the_frame_or_the_grain(material: Material) -> None:
    F, Q = random_states(100), random_rotation(1)
    energy, tau, _ = material.evaluate(F)
    turned, isotropic = material.evaluate(Q @ F), material.evaluate(F @ Q)
    scale = np.abs(tau).max()
    assert turned[0] == pytest.approx(energy)
    assert isotropic[0] == pytest.approx(energy)
    assert tensor(turned[1]) == pytest.approx(Q @ tensor(tau) @ Q.T, abs=1e-11 * scale)
    assert isotropic[1] == pytest.approx(tau, abs=1e-11 * scale)


def test_rest_has_no_energy_no_stress_and_the_shear_modulus(material: Material) -> None:
    energy, tau, c = material.evaluate(np.eye(3)[None])
    assert energy[0] == pytest.approx(0, abs=1e-15)
    assert np.abs(tau).max() < 1e-14
    assert c[0, 3, 3] == pytest.approx(material.law.shear_modulus)


def test_equibiaxial_tension_is_uniaxial_compression(material: Material) -> None:
    stretch = np.linspace(1.1, 2, 7)
    biaxial = trace_curve(material, Mode.EQUIBIAXIAL, stretch)
    uniaxial = trace_curve(material, Mode.UNIAXIAL, stretch**-2)
    assert biaxial.cauchy == pytest.approx(-uniaxial.cauchy, rel=1e-9)


def test_equal_principal_stretches_are_no_special_case() -> None:
    ogden = get_material("ogden:0.63,1.3,0.0012,5,-0.01,-2")
    exact = ogden.evaluate(np.diag([1.2, 1.2, 0.8])[None])[2]
    near = ogden.evaluate(np.diag([1.2, 1.2 + 1e-5, 0.8])[None])[2]
    assert near == pytest.approx(exact, rel=1e-4, abs=1e-6)


def test_every_library_entry_has_a_source() -> None:
    for name in list_materials():
        assert get_material(name).source


def test_a_material_survives_its_data(material: Material) -> None:
    again = material_from_data({"name": material.name, **material.key_data()})
    assert again.law.constants == material.law.constants
    assert again.bulk_ratio == material.bulk_ratio


@pytest.mark.parametrize("text", ["ecoflex", "yeoh:1,2", "yeoh:a,b,c", "neo-hooke:-1", "ogden:1", "neo-hooke:nan"])
def test_a_material_that_makes_no_sense_is_refused_with_a_remedy(text: str) -> None:
    with pytest.raises(PalpateError, match=r"Known|Write|must be positive|takes"):
        get_material(text)
