"""Every lens of the package, one row each."""

import pytest

from palpate.camera import LENSES, Lens
from palpate.camera.lenses.brown import Brown
from palpate.camera.lenses.kannala_brandt import KannalaBrandt
from palpate.camera.lenses.rational import Rational
from palpate.testing import LensSuite

ROWS = [
    Brown(),
    Brown(-0.2, 0.05, 0.001, -0.002, 0.01),
    Brown(-1.0),
    KannalaBrandt(),
    KannalaBrandt(-0.048, 0.011, -0.055, 0.021),
    KannalaBrandt(-0.5),
    Rational(),
    Rational(2.1, 0.6, 0.001, -0.002, 0.01, 2.3, 0.8, 0.03, 0.002, -0.001, 0.001, 0.002),
]


def test_every_lens_has_a_row() -> None:
    assert {lens.name for lens in ROWS} == set(LENSES.names)


class TestLens(LensSuite):
    @pytest.fixture(params=ROWS, ids=str)
    def lens(self, request: pytest.FixtureRequest) -> Lens:
        found: Lens = request.param
        return found
