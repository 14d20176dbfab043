"""What single laws are known for, and materials by name; what every law must satisfy is in tests/contracts."""

import numpy as np
import pytest

from errors import refused
from palpate.material import (
    Material,
    Mode,
    get_material,
    list_materials,
    material_from_data,
    trace_curve,
)

LAWS = {
    "yeoh": "zaid_2024_ecoflex_00_30",
    "neo-hooke": "neo-hooke:0.0141",
    "mooney-rivlin": "mooney-rivlin:0.1,0.05",
    "mooney-rivlin-3": "mooney-rivlin:0.1,0.05,0.01",
    "mooney-rivlin-5": "mooney-rivlin:0.1,0.05,0.01,-0.004,0.003",
    "gent": "gent:0.03,80",
    "ogden-1": "ogden:0.02,2.7",
    "ogden-2": "ogden:0.02,2.5,-0.004,-1.5",
    "ogden-3": "ogden:0.63,1.3,0.0012,5,-0.01,-2",
    "arruda-boyce": "arruda-boyce:0.028,3",
    "unstable yeoh": "yeoh:0.1,-0.01,0.001",
}
STATES = 1000


def random_states(count: int = STATES, seed: int = 0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    F = np.eye(3) + 0.25 * rng.normal(size=(4 * count, 3, 3))
    return F[np.linalg.det(F) > 0.3][:count]


@pytest.fixture(params=LAWS)
def material(request: pytest.FixtureRequest) -> Material:
    return get_material(LAWS[request.param])


def test_chains_lock_at_gents_limit() -> None:
    material = get_material("gent:0.03,10")
    lock = 3.5  # I1 - 3 = 9.82 there, 10.96 at 3.7
    inside, outside = np.diag([lock, lock**-0.5, lock**-0.5]), np.diag([3.7, 3.7**-0.5, 3.7**-0.5])
    energy, _, _ = material.evaluate(np.array([inside, outside]))
    assert np.isfinite(energy[0])
    assert energy[1] == np.inf


@pytest.mark.parametrize("text", ["gent:0.0282,1e7", "arruda-boyce:0.0282,1e3"])
def test_chains_that_do_not_lock_are_neo_hookean(text: str) -> None:
    F = random_states(100)
    plain, long = get_material("neo-hooke:0.0141").evaluate(F), get_material(text).evaluate(F)
    for a, b in zip(long, plain, strict=True):
        assert a == pytest.approx(b, rel=2e-6, abs=2e-6 * np.abs(b).max())


def test_arruda_and_boyces_series_is_near_the_inverse_langevin_function() -> None:
    """``dW/dI1 = mu lm / (6 lc) L^-1(lc / lm)`` of the eight-chain model; half the locking stretch."""
    mu, lm = 0.028, 3.0
    stretch = np.linspace(1.05, 2.3, 20)
    x = stretch**2 + 2 / stretch
    share = np.sqrt(x / 3) / lm
    beta = np.linspace(1e-3, 30, 300_000)
    inverse = np.interp(share, 1 / np.tanh(beta) - 1 / beta, beta)
    expected = 2 * (stretch - stretch**-2) * mu * lm / (6 * np.sqrt(x / 3)) * inverse
    ours = trace_curve(get_material(f"arruda-boyce:{mu},{lm}"), Mode.UNIAXIAL, stretch).nominal
    assert ours == pytest.approx(expected, rel=5e-3)


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


def test_every_library_entry_has_source_licence_range_and_quality() -> None:
    for name in list_materials():
        material = get_material(name)
        assert material.name == name
        assert material.source
        assert material.licence
        assert material.quality
        assert 0 < material.stretch_range[0] < material.stretch_range[1] < 10


def test_a_material_survives_its_data(material: Material) -> None:
    again = material_from_data({"name": material.name, **material.key_data()})
    assert again.law.constants == material.law.constants
    assert again.law == material.law
    assert again.bulk_ratio == material.bulk_ratio


REFUSED = [
    ("ecoflex", ("material-unknown", "ecoflex")),
    ("yeoh:1,2", ("law-constant-count", "yeoh", "C10,C20,C30", 2)),
    ("yeoh:a,b,c", ("constants-not-numbers", "a,b,c")),
    ("neo-hooke:-1", ("shear-modulus-not-positive", -1)),
    ("ogden:1", ("law-constant-count", "ogden", 1)),
    ("neo-hooke:nan", ("shear-modulus-not-positive", "nan")),
    ("gent:0.1", ("law-constant-count", "gent", 1)),
    ("gent:0.1,-3", ("law-constant-not-positive", "Jm", -3)),
    ("arruda-boyce:0.1,0", ("law-constant-not-positive", "lm", 0)),
    ("mooney-rivlin:1,2,3,4", ("law-constant-count", "mooney-rivlin", 4)),
]


@pytest.mark.parametrize(("text", "says"), REFUSED)
def test_a_material_that_makes_no_sense_is_refused_with_a_remedy(text: str, says: tuple[object, ...]) -> None:
    with refused(*says) as caught:
        get_material(text)
    assert caught.value.remedy
