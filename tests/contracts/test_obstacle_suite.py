"""Every obstacle of the package, one row each, over a dome and an ellipsoid."""

import pytest

from palpate.design import Dome
from palpate.design.barrel import BarrelSpec
from palpate.design.ellipsoid import Ellipsoid
from palpate.fea import OBSTACLES, BallSpec, CylinderSpec, ObstacleSpec, WallSpec
from palpate.fea.edge import EdgeSpec
from palpate.fea.plate import PlateSpec
from palpate.fea.route import RouteSpec
from palpate.fea.side_wall import SideWallSpec
from palpate.mesh import Mesh, MeshSpec, mesh_skin
from palpate.testing import ObstacleSuite

ROWS: list[ObstacleSpec] = [
    WallSpec(tilt_deg=7),
    BallSpec(radius=6, offset=3),
    BallSpec(radius=40),
    CylinderSpec(radius=5, offset=-4),
    CylinderSpec(radius=5),
    EdgeSpec(radius=3, offset=2),
    EdgeSpec(radius=2, opening_deg=150, offset=-6),
    PlateSpec(tilt_deg=5, hole_diameter=4, edge_radius=1),
    PlateSpec(tilt_deg=3, hole_diameter=3, edge_radius=0.5, sink_diameter=6, offset=2),
    RouteSpec(waypoints=((3, 0, 0, 4, -2), (3, 1, 0.5, 4, -2, 5))),
]


SIDE_ROWS: list[ObstacleSpec] = [SideWallSpec(), SideWallSpec(tilt_deg=94)]


def test_every_obstacle_has_a_row() -> None:
    assert {type(row) for row in (*ROWS, *SIDE_ROWS)} == {OBSTACLES.get(name) for name in OBSTACLES.names}


class TestObstacle(ObstacleSuite):
    @pytest.fixture(params=ROWS, ids=lambda spec: spec.label)
    def spec(self, request: pytest.FixtureRequest) -> ObstacleSpec:
        found: ObstacleSpec = request.param
        return found

    @pytest.fixture(params=[Dome(20.0, 20.0, 2.0), Ellipsoid(14.0, 20.0, 2.0, 0.8)], ids=lambda skin: skin.name)
    def mesh(self, request: pytest.FixtureRequest) -> Mesh:
        return mesh_skin(request.param, MeshSpec(cells=6))


class TestObstacleAtTheSide(ObstacleSuite):
    @pytest.fixture(params=SIDE_ROWS, ids=lambda spec: spec.label)
    def spec(self, request: pytest.FixtureRequest) -> ObstacleSpec:
        found: ObstacleSpec = request.param
        return found

    @pytest.fixture
    def mesh(self) -> Mesh:
        return mesh_skin(BarrelSpec().build(), MeshSpec(cells=6, core=1))
