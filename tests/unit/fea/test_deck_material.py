"""The constants of a deck mean the same law in CalculiX as here: one brick, stretched along z."""

import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from errors import check_values
from needs import needs_program
from palpate.fea import Dialect
from palpate.fea.deck_material import material_lines
from palpate.fea.read_deck_results import read_blocks
from palpate.material import Material, Relaxation, get_material

LAWS = {
    "neo-hooke": "neo-hooke:0.02",
    "yeoh": "yeoh:0.0141156,0.003,0.0005",
    "mooney-rivlin": "mooney-rivlin:0.02,0.01",
    "second order": "polynomial:0.01,0.005,0.002,0.001,0.0005,0",
    "third order": "polynomial:0.01,0.005,0.002,0.001,0,0.0004",
    "ogden": "ogden:0.02,2.5,-0.004,-1.5",
    "ogden of three terms": "ogden:0.02,1.3,0.003,4.0,-0.004,-2.0",
    "arruda-boyce": "arruda-boyce:0.02,2.2",
}
STRETCH = 1.6

BRICK = """*NODE, NSET=ALL
1, 0, 0, 0
2, 1, 0, 0
3, 1, 1, 0
4, 0, 1, 0
5, 0, 0, 1
6, 1, 0, 1
7, 1, 1, 1
8, 0, 1, 1
*ELEMENT, TYPE=C3D8, ELSET=ONE
1, 1, 2, 3, 4, 5, 6, 7, 8
*NSET, NSET=TOP
5, 6, 7, 8
{material}
*SOLID SECTION, ELSET=ONE, MATERIAL=SILICONE
*BOUNDARY
1, 1, 3
4, 1
5, 1
8, 1
2, 2, 3
3, 3
4, 3
5, 2
6, 2
*STEP, NLGEOM
*STATIC
0.1, 1.
*BOUNDARY
TOP, 3, 3, {travel}
*NODE PRINT, NSET=TOP, TOTALS=ONLY, FREQUENCY=1000
RF
*END STEP
"""


def nominal_stress(material: Material, stretch: float) -> float:
    """dW/dl of ``diag(s, s, l)`` where the lateral stretch s makes W least."""

    def energy(along: float) -> float:
        def of(s: float) -> float:
            F = np.diag([s, s, along])
            J = float(np.linalg.det(F))
            volume = (J - 1) ** 2 if material.law.name != "arruda-boyce" else (J**2 - 1) / 2 - np.log(J)
            return float(material.evaluate(F[None])[0][0] + 0.5 * material.bulk_modulus * volume)

        return float(minimize_scalar(of, bounds=(0.5, 1.2), options={"xatol": 1e-10}).fun)

    return (energy(stretch + 1e-3) - energy(stretch - 1e-3)) / 2e-3


@needs_program("calculix-ccx")
@pytest.mark.parametrize("law", LAWS)
def test_calculix_reads_the_law_we_mean(law: str, tmp_path: Path) -> None:
    material = Material(law, get_material(LAWS[law]).law, bulk_ratio=20.0)
    text = BRICK.format(material="\n".join(material_lines(material, Dialect.CALCULIX)), travel=STRETCH - 1)
    (tmp_path / "one.inp").write_text(text)
    subprocess.run(["ccx", "one"], cwd=tmp_path, check=True, capture_output=True, timeout=60)
    (force,) = [block.rows[0, 2] for block in read_blocks(tmp_path / "one.dat")]
    assert force == pytest.approx(nominal_stress(material, STRETCH), rel=2e-4)


@pytest.mark.parametrize("dialect", Dialect)
def test_a_relaxation_is_told_in_comments_and_changes_no_line_of_the_press(dialect: Dialect) -> None:
    plain = get_material("zaid_2024_ecoflex_00_30")
    fading = replace(plain, relaxation=Relaxation((0.1, 0.05), (0.5, 20.0)))
    before, lines = list(material_lines(plain, dialect)), list(material_lines(fading, dialect))
    assert [line for line in lines if not line.startswith("**")] == [line for line in before if line[:2] != "**"]
    told = "\n".join(lines)
    assert "long-term" in told
    if dialect is Dialect.ABAQUS:
        assert "** *VISCOELASTIC, TIME=PRONY\n** 0.1, 0., 0.5\n** 0.05, 0., 20" in told
        assert "MODULI=LONG TERM" in told
    else:
        check_values(told, 0.1, "0.5 s", 0.05, "20 s")
