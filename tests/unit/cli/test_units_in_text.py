"""Numbers that people read are those of the JSON, in the unit that stands beside them."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from palpate.cli import main
from palpate.material import get_material

RECIPE = ("--depth", "4", "--step", "0.5")


def shown(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    with pytest.raises(SystemExit) as left:
        main(list(words))
    assert not left.value.code
    return capsys.readouterr().out


def number(pattern: str, text: str) -> float:
    found = re.search(pattern.replace("#", r"(-?[\d.]+(?:e-?\d+)?)"), text)
    assert found, text
    return float(found[1])


@pytest.mark.parametrize("name", ["zaid_2024_ecoflex_00_30", "neo-hooke:0.05"])
def test_moduli_of_a_material_are_in_kpa(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    facts = json.loads(shown(capsys, "material", "show", name, "--json"))
    text = shown(capsys, "material", "show", name)
    material = get_material(name)
    assert number("initial E # kPa", text) == pytest.approx(1000 * material.young_modulus, rel=1e-3)
    assert number("mu # kPa", text) == pytest.approx(1000 * material.law.shear_modulus, rel=1e-3)
    assert number("K/mu #,", text) == pytest.approx(material.bulk_modulus / material.law.shear_modulus, rel=1e-4)
    assert facts["young_modulus_mpa"] == pytest.approx(material.young_modulus)
    assert number("Poisson's ratio #", text) == pytest.approx(facts["poisson_ratio"], abs=1e-5)
    assert 0.5 * (1 - material.young_modulus / (3 * material.bulk_modulus)) == pytest.approx(
        facts["poisson_ratio"], abs=2e-4
    )


def test_the_list_of_materials_has_the_young_modulus_in_kpa(capsys: pytest.CaptureFixture[str]) -> None:
    facts = json.loads(shown(capsys, "material", "list", "--json"))
    facts = facts["rows"]
    text = shown(capsys, "material", "list")
    for item in facts:
        row = next(line for line in text.splitlines() if line.startswith(item["name"]))
        assert float(row.split()[2]) == pytest.approx(1e3 * item["young_modulus_mpa"], rel=2e-2)


def test_a_deck_has_the_megabytes_of_its_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "press.inp"
    text = shown(capsys, "design", "deck", "-o", str(path), "--cells", "8")
    assert number("# MB", text) == pytest.approx(path.stat().st_size / 1e6, abs=0.051)


def test_secants_of_a_fit_and_greatest_stress_are_in_kpa(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    stretch = np.linspace(1.0, 2.0, 60)
    stress = 0.04 * (stretch - stretch**-2.0)
    rows = [f"{a - 1:.6f},{b:.8f}" for a, b in zip(stretch, stress, strict=True)]
    path = tmp_path / "pull.csv"
    path.write_text("\n".join(["strain,stress_MPa", *rows]) + "\n")
    words = ("material", "fit", str(path), "--model", "neo-hooke")
    text, facts = shown(capsys, *words), json.loads(shown(capsys, *words, "--json"))
    assert number("initial shear modulus # kPa", text) == pytest.approx(40.0, rel=0.01)
    assert facts["shear_modulus_mpa"] == pytest.approx(0.04, rel=0.01)
    secant = 1e3 * 0.04 * (1.1 - 1.1**-2.0) / 0.1
    assert number("data # kPa", text) == pytest.approx(secant, rel=0.02)
    assert number("fit # kPa", text) == pytest.approx(secant, rel=0.02)
    assert f"{1e3 * stress[-1]:.4g}" in text
