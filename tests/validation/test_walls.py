import numpy as np
import pytest

from palpate.verify.equilibrium import make_solid
from palpate.verify.mapped import Turn, even
from validation.walls import elastic, load_top, middle_rim, press_round, round_wall, through, wall

ANGLE, RADIUS, THICKNESS = 0.6, 20.0, 1.0


def make_cap():
    grid = round_wall(RADIUS, THICKNESS, ANGLE * even(6), Turn(2))
    return grid, make_solid(grid, elastic(1.0, 0.3), np.zeros(grid.nodes.shape, bool))


def test_the_law_has_the_modulus_and_ratio_that_it_is_made_of() -> None:
    assert elastic(3.0, 0.3).young_modulus == pytest.approx(3.0, rel=1e-9)
    assert elastic(3.0, 0.5).young_modulus == pytest.approx(3.0, rel=1e-3)


def test_a_quarter_of_a_cap_has_a_quarter_of_its_volume() -> None:
    _, solid = make_cap()
    out, inside = RADIUS + THICKNESS / 2, RADIUS - THICKNESS / 2
    volume = 2 * np.pi / 3 * (1 - np.cos(ANGLE)) * (out**3 - inside**3)
    assert 4 * solid.cells.weight.sum() == pytest.approx(volume, rel=1e-4)


def test_a_load_on_the_top_is_a_quarter_downward_and_near_the_axis() -> None:
    grid, solid = make_cap()
    force = load_top(solid, ANGLE / 6)
    assert force.sum(axis=0) == pytest.approx([0.0, 0.0, -0.25])
    loaded = np.hypot(*grid.nodes[np.abs(force[:, 2]) > 0, :2].T)
    assert loaded.max() <= (RADIUS + THICKNESS / 2) * np.sin(ANGLE / 6) + 1e-9


def test_a_pressure_pushes_down_by_the_area_of_the_base() -> None:
    _, solid = make_cap()
    downward = press_round(solid, THICKNESS)[:, 2].sum()
    assert 4 * downward == pytest.approx(-np.pi * (RADIUS * np.sin(ANGLE)) ** 2, rel=2e-3)


def test_the_rim_is_the_middle_of_the_last_edge() -> None:
    grid, _ = make_cap()
    rim = grid.nodes[middle_rim(grid, RADIUS, THICKNESS, ANGLE)]
    assert len(rim) == 9
    assert np.linalg.norm(rim, axis=1) == pytest.approx(RADIUS)


def test_nodes_through_a_flat_wall_stand_one_above_another() -> None:
    up = np.array([0.0, 0.0, 1.0])
    grid = wall(lambda q: np.pad(q * [10.0, 5.0], ((0, 0), (0, 1))), lambda q: np.tile(up, (len(q), 1)), 0.8, (2, 3))
    nodes = grid.nodes[through(grid, np.array([10.0, 5.0, 0.0]), up, 0.8)]
    assert nodes[:, 2] == pytest.approx([-0.4, 0.0, 0.4])
