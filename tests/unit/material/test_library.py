"""Every fit of the library comes out of its raw data again, and its files say what a user must know."""

from pathlib import Path

import pytest

from palpate.material import (
    FitSpec,
    PrepareSpec,
    TestFileSpec,
    find_stable_ranges,
    fit_material,
    get_material,
    list_materials,
    prepare_sample,
    rank_models,
    read_test_file,
)

DATA = Path(__file__).parent / "data"
PLAIN = TestFileSpec()
NUMBERED = {"strain": "2", "strain_unit": "stretch", "stress": "1", "stress_unit": "MPa"}
MEUNIER = {"UT": "uniaxial", "ET": "equibiaxial", "PS": "planar"}
FITS: dict[str, tuple[list[tuple[str, TestFileSpec]], FitSpec]] = {
    "marechal_2020_ecoflex_00_30": (
        [("marechal_2020/Ecoflex 00-30.csv", PLAIN)],
        FitSpec(model="yeoh", stable=True),
    ),
    "marechal_2020_ecoflex_00_50": (
        [("marechal_2020/Ecoflex 00-50.csv", PLAIN)],
        FitSpec(model="yeoh", stable=True),
    ),
    "marechal_2020_dragon_skin_10": (
        [("marechal_2020/Dragon Skin 10 MEDIUM.csv", PLAIN)],
        FitSpec(model="ogden-1"),
    ),
    "marechal_2020_dragon_skin_30": (
        [("marechal_2020/Dragon Skin 30.csv", PLAIN)],
        FitSpec(model="ogden-1"),
    ),
    "meunier_2008_silicone": (
        [
            (f"meunier_2008/{mode}_stress_stretch.txt", TestFileSpec(loading=loading, **NUMBERED))
            for mode, loading in MEUNIER.items()
        ],
        FitSpec(model="yeoh"),
    ),
}


def test_every_fit_of_our_own_is_tested() -> None:
    assert set(FITS) == set(list_materials()) - {"zaid_2024_ecoflex_00_30"}


@pytest.mark.parametrize("name", FITS)
def test_a_fit_of_the_library_comes_out_of_its_data(name: str) -> None:
    files, spec = FITS[name]
    samples = [
        prepare_sample(sample, PrepareSpec(max_stretch=5))
        for file, bench in files
        for sample in read_test_file(DATA / file, bench)
    ]
    fit, material = fit_material(samples, spec), get_material(name)
    assert list(fit.law.constants.values()) == pytest.approx(list(material.law.constants.values()), rel=1e-6)
    made = fit.material(name)
    assert made.stretch_range == pytest.approx(material.stretch_range, rel=1e-4)
    assert made.quality == material.quality
    assert min(item.r2 for item in fit.quality) > 0.99


@pytest.mark.parametrize("name", list_materials())
def test_every_material_of_the_library_is_stable(name: str) -> None:
    assert all(item.whole for item in find_stable_ranges(get_material(name).law))


def test_the_two_sources_of_ecoflex_00_30_differ_by_nearly_two() -> None:
    paper, shared = get_material("zaid_2024_ecoflex_00_30"), get_material("marechal_2020_ecoflex_00_30")
    assert paper.law.shear_modulus / shared.law.shear_modulus == pytest.approx(1.77, abs=0.02)
    assert "too\n" in shared.caution or "too soft" in shared.caution


def test_meuniers_silicone_is_described_best_by_yeoh_when_a_mode_is_left_out() -> None:
    """Ogden's six constants win by Akaike's criterion and are absurd in the mode that was left out."""
    files, _ = FITS["meunier_2008_silicone"]
    samples = [sample for file, bench in files for sample in read_test_file(DATA / file, bench)]
    ranked = {item.name: item for item in rank_models(samples)}
    assert next(iter(ranked)) == "ogden-3"
    assert ranked["ogden-3"].left_out > 10
    assert min(ranked.values(), key=lambda item: item.left_out).name == "yeoh"
