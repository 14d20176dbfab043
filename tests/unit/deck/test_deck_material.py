"""The constants of a deck mean the same law in CalculiX as here: one brick, stretched along z."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from palpate.deck import Dialect
from palpate.deck.material import material_lines
from palpate.deck.read_results import read_blocks
from palpate.material import Law, Material, Polynomial, get_material, ogden

LAWS: dict[str, Law] = {
    "neo-hooke": get_material("neo-hooke:0.02").law,
    "yeoh": get_material("yeoh:0.0141156,0.003,0.0005").law,
    "mooney-rivlin": get_material("mooney-rivlin:0.02,0.01").law,
    "second order": Polynomial("second", c10=0.01, c01=0.005, c20=0.002, c11=0.001, c02=0.0005),
    "third order": Polynomial("third", c10=0.01, c01=0.005, c20=0.002, c11=0.001, c30=0.0004),
    "ogden": ogden(0.02, 2.5, -0.004, -1.5),
    "ogden of three terms": ogden(0.02, 1.3, 0.003, 4.0, -0.004, -2.0),
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
            volumetric = 0.5 * material.bulk_modulus * (np.linalg.det(F) - 1) ** 2
            return float(material.evaluate(F[None])[0][0] + volumetric)

        return float(minimize_scalar(of, bounds=(0.5, 1.2), options={"xatol": 1e-10}).fun)

    return (energy(stretch + 1e-3) - energy(stretch - 1e-3)) / 2e-3


@pytest.mark.skipif(shutil.which("ccx") is None, reason="ccx is not installed: apt install calculix-ccx")
@pytest.mark.parametrize("law", LAWS)
def test_calculix_reads_the_law_we_mean(law: str, tmp_path: Path) -> None:
    material = Material(law, LAWS[law], bulk_ratio=20.0)
    text = BRICK.format(material="\n".join(material_lines(material, Dialect.CALCULIX)), travel=STRETCH - 1)
    (tmp_path / "one.inp").write_text(text)
    subprocess.run(["ccx", "one"], cwd=tmp_path, check=True, capture_output=True, timeout=60)
    (force,) = [block.rows[0, 2] for block in read_blocks(tmp_path / "one.dat")]
    assert force == pytest.approx(nominal_stress(material, STRETCH), rel=2e-4)
