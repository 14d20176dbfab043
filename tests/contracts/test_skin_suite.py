"""Every skin of the package, one row each."""

import pytest

from palpate.design import SKINS, ConeSpec, Dome, Skin, SplineSpec
from palpate.design.cone import Cone
from palpate.design.ellipsoid import Ellipsoid
from palpate.design.flat_pad import FlatPadSpec
from palpate.design.pinned import PinnedDome
from palpate.testing import SkinSuite

ROWS = [
    Dome(20.0, 20.0, 2.0),
    Dome(10.0, 20.0, 1.0),
    Dome(30.0, 20.0, 3.0),
    Ellipsoid(20.0, 20.0, 2.0, 1.3),
    Ellipsoid(12.0, 20.0, 2.0, 0.7),
    Ellipsoid(28.0, 20.0, 1.0, 1.0),
    Ellipsoid(18.0, 20.0, 2.0, 0.9, taper=1.6),
    ConeSpec(height=22, base_radius=15, thickness=2, edge_radius=6).build(),
    ConeSpec(height=20, base_radius=14, thickness=1.5, flat_radius=5, edge_radius=5, taper=0.6).build(),
    Cone(30.0, 10.0, 1.0, 0.0, 10.0),
    SplineSpec(height=16, base_radius=20, thickness=2, points=((0.5, 0.9), (0.85, 0.5))).build(),
    SplineSpec(height=20, base_radius=14, points=((0.6, 0.9), (1.1, 0.4)), taper=1.3).build(),
    PinnedDome(20.0, 20.0, 2.0, 2.0),
    PinnedDome(12.0, 20.0, 1.0, 1.0),
    FlatPadSpec(height=3.5, base_radius=10.4, thickness=0.5, stretch=25.25 / 20.75).build(),
    FlatPadSpec(
        height=4, base_radius=12, thickness=1, stretch=1.0, squareness=2, flat_radius=8, edge_radius=3
    ).build(),
    FlatPadSpec(height=5, base_radius=9, thickness=0.8, stretch=2.0, squareness=3.5, flat_radius=6).build(),
]


def test_every_skin_has_a_row() -> None:
    """A barrel has no apex, which the suite asks for, and checks of its own (tests/unit/design/test_barrel.py)."""
    assert {row.spec_data.get("kind", "dome") for row in ROWS} == set(SKINS.names) - {"barrel"}


class TestSkin(SkinSuite):
    @pytest.fixture(params=ROWS, ids=lambda skin: skin.name)
    def skin(self, request: pytest.FixtureRequest) -> Skin:
        found: Skin = request.param
        return found
