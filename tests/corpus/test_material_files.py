"""Exports of test machines with headings, units and rows that are seldom: read with the modulus that they hold."""

from pathlib import Path

import numpy as np
import pytest

from errors import refused
from palpate.material import Loading, TestFileSpec, read_test_file

MU_MPA, GAUGE_MM, SECTION_MM2 = 0.3, 25.0, 12.0
STRETCH = np.linspace(1.0, 2.0, 41)
STRAIN = STRETCH - 1.0
STRESS = MU_MPA * (STRETCH - STRETCH**-2)


def table(header: str, *columns: np.ndarray, mark: str = ",", cell: str = "{:.7g}", end: str = "") -> str:
    """Text of a file; a semicolon between cells goes with decimal commas."""
    rows = (mark.join(cell.format(value) for value in row) for row in zip(*columns, strict=True))
    text = "\n".join(rows)
    return f"{header}\n{text.replace('.', ',') if mark == ';' else text}\n{end}"


FORCE_N, TRAVEL_MM = STRESS * SECTION_MM2, STRAIN * GAUGE_MM
FILES = {
    "greek letters": table("ε_eng [%],σ_eng [MPa]", 100 * STRAIN, STRESS),
    "names of letters": table("epsilon,sigma (kPa)", STRAIN, 1e3 * STRESS),
    "Italian": table("Tempo (s);Deformazione (%);Sforzo (MPa)", STRAIN, 100 * STRAIN, STRESS, mark=";"),
    "Spanish": table("Desplazamiento (mm);Carga (N)", TRAVEL_MM, FORCE_N, mark=";"),
    "Portuguese": table("Deformação (%);Tensão (MPa)", 100 * STRAIN, STRESS, mark=";"),
    "texture analyser": table("Force (g),Distance (mm),Time (sec)", FORCE_N / 9.80665e-3, TRAVEL_MM, STRAIN),
    "microstrain": table("Strain (µε),Stress (Pa)", 1e6 * STRAIN, 1e6 * STRESS),
    "gigapascals": table("strain,stress [GPa]", STRAIN, 1e-3 * STRESS),
    "newtons a square centimetre": table("Strain [%],Stress [N/cm²]", 100 * STRAIN, 100 * STRESS),
    "statistics below": table(
        "Strain (%),Stress (MPa)", 100 * STRAIN, STRESS, end="Max,0.525\nMean,0.3\nStd. dev.,0.1\n"
    ),
    "texts of a spreadsheet": table("Strain;Stress (MPa)", STRAIN, STRESS, mark=";", cell='="{:.7g}"'),
}


@pytest.mark.parametrize("name", FILES)
def test_the_modulus_is_that_of_the_file(name: str, tmp_path: Path) -> None:
    path = tmp_path / "test.csv"
    path.write_text(FILES[name], encoding="utf-8")
    spec = TestFileSpec(loading=Loading.TENSION, gauge_length=GAUGE_MM, section=SECTION_MM2)
    (sample,) = read_test_file(path, spec)
    assert len(sample.stretch) == len(STRETCH)
    assert sample.stretch == pytest.approx(STRETCH, abs=1e-6)
    assert sample.nominal == pytest.approx(STRESS, abs=1e-6)


def test_a_faulty_row_is_no_statistic(tmp_path: Path) -> None:
    path = tmp_path / "test.csv"
    path.write_text(table("Strain,Stress (MPa)", STRAIN, STRESS, end="broken,0.5\n"))
    with refused("value-not-number"):
        read_test_file(path, TestFileSpec(loading=Loading.TENSION))


def test_a_rate_is_no_strain_and_a_lot_of_a_chemical_no_stress(tmp_path: Path) -> None:
    path = tmp_path / "test.csv"
    path.write_text(
        table(
            "Extension (mm),Stress (MPa),dε/dt (1/s),Sigma-Aldrich lot", TRAVEL_MM, STRESS, 0.01 + 0 * STRAIN, STRAIN
        )
    )
    (sample,) = read_test_file(path, TestFileSpec(loading=Loading.TENSION, gauge_length=GAUGE_MM))
    assert sample.stretch == pytest.approx(STRETCH, abs=1e-6)


def test_samples_named_like_a_statistic_are_kept(tmp_path: Path) -> None:
    path = tmp_path / "test.csv"
    rows = [f"{name},{a:.6g},{b:.6g}" for name in ("L", "max") for a, b in zip(STRAIN, STRESS, strict=True)]
    path.write_text("\n".join(["Sample,Strain (mm/mm),Stress (MPa)", *rows]))
    assert [len(one.stretch) for one in read_test_file(path, TestFileSpec(loading=Loading.TENSION))] == [41, 41]
