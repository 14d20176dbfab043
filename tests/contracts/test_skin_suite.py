"""Every skin of the package, one row each."""

import pytest

from palpate.design import SKINS, Dome, Ellipsoid, Skin
from palpate.testing import SkinSuite

ROWS = [
    Dome(20.0, 20.0, 2.0),
    Dome(10.0, 20.0, 1.0),
    Dome(30.0, 20.0, 3.0),
    Ellipsoid(20.0, 20.0, 2.0, 1.3),
    Ellipsoid(12.0, 20.0, 2.0, 0.7),
    Ellipsoid(28.0, 20.0, 1.0, 1.0),
]


def test_every_skin_has_a_row() -> None:
    assert {row.spec_data.get("kind", "dome") for row in ROWS} == set(SKINS.names)


class TestSkin(SkinSuite):
    @pytest.fixture(params=ROWS, ids=lambda skin: skin.name)
    def skin(self, request: pytest.FixtureRequest) -> Skin:
        found: Skin = request.param
        return found
