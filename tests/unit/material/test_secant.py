"""The stiffness at small strain, which is what a sensor feels, is held against that of the data."""

import json
from pathlib import Path

import numpy as np
import pytest

from palpate.cli import main
from palpate.material import FitSpec, Loading, Sample, compare_secants, fit_material


def soft_start(far: float, rows: int = 300) -> Sample:
    """Stress by a formula: 30 kPa at rest, stiffening so late that a law over the whole range cannot follow."""
    strain = np.linspace(0.01, far, rows)
    return Sample("drawn", Loading.TENSION, 1 + strain, 0.03 * strain + 2e-4 * strain**3.5)


def fit_file(tmp_path: Path, capsys: pytest.CaptureFixture[str], *flags: str) -> dict:
    sample = soft_start(9)
    rows = [f"{a:.9g},{b:.9g}" for a, b in zip(sample.stretch, sample.nominal, strict=True)]
    path = tmp_path / "tension.csv"
    path.write_text("\n".join(["stretch,stress (MPa)", *rows]))
    with pytest.raises(SystemExit) as left:
        main(["material", "fit", str(path), "--alone", "--json", *flags])
    assert left.value.code in (0, None)
    return json.loads(capsys.readouterr().out)


def test_the_secant_of_the_data_is_that_of_the_formula() -> None:
    sample = soft_start(3)
    (found,) = compare_secants([sample], fit_material([sample], FitSpec(model="yeoh")))
    assert found.measured == pytest.approx(0.03 + 2e-4 * 0.1**2.5, rel=0.01)


@pytest.mark.parametrize("side", [1, -1])
def test_a_law_is_met_by_its_own_secant(side: int) -> None:
    stretch = 1 + side * np.linspace(0.02, 0.4, 30)
    sample = Sample("neo", Loading.UNIAXIAL, stretch, 0.02 * (stretch - stretch**-2))
    (found,) = compare_secants([sample], fit_material([sample], FitSpec(model="neo-hooke")))
    assert found.loading is (Loading.TENSION if side > 0 else Loading.COMPRESSION)
    assert abs(found.excess) < 0.02


def test_data_that_start_beyond_have_no_secant() -> None:
    stretch = np.linspace(1.5, 3, 30)
    sample = Sample("late", Loading.TENSION, stretch, 0.02 * (stretch - stretch**-2))
    assert compare_secants([sample], fit_material([sample], FitSpec(model="neo-hooke"))) == ()


def test_a_fit_far_too_stiff_at_small_strain_says_so_and_the_flag_it_names_mends_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = fit_file(tmp_path, capsys)
    assert whole["modes"][0]["r2"] > 0.99
    (said,) = [text for text in whole["warnings"] if "10 % strain" in text]
    assert "--max-stretch 1.5" in said
    near = fit_file(tmp_path, capsys, "--max-stretch", "1.5")
    assert not [text for text in near["warnings"] if "10 % strain" in text]
    off = [abs(facts["secants"][0]["fitted_mpa"] / 0.03 - 1) for facts in (whole, near)]
    assert off[0] > 0.15 > 3 * off[1]
