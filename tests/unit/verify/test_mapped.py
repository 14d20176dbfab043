import numpy as np
import pytest

from palpate.material import Material, NeoHooke
from palpate.verify.equilibrium import make_solid
from palpate.verify.mapped import Grid, Turn, even, join, map_block, revolve
from validation.graded import graded

RUBBER = Material("rubber", NeoHooke(0.5))


def volume(grid: Grid) -> float:
    solid = make_solid(grid, RUBBER, np.zeros(grid.nodes.shape, bool))
    assert (solid.cells.weight > 0).all()
    return float(solid.cells.weight.sum())


def test_blocks_that_touch_share_their_nodes() -> None:
    left = map_block((even(2), even(1), even(1)), lambda q: q)
    right = map_block((even(1), even(1), even(1)), lambda q: q + np.array([1.0, 0.0, 0.0]))
    grid = join(left, right)
    assert len(grid.nodes) == 7 * 3 * 3
    assert volume(grid) == pytest.approx(2.0, rel=1e-12)


@pytest.mark.parametrize(("cells", "error"), [(1, 2e-3), (2, 1e-4)])
def test_a_turned_section_fills_the_cylinder(cells: int, error: float) -> None:
    grid = join(revolve(lambda q: q * [3.0, 2.0], (even(3), even(2)), Turn(cells, quarters=4), solid=True))
    assert volume(grid) == pytest.approx(18 * np.pi, rel=error)


def test_a_quarter_ends_on_the_coordinate_planes() -> None:
    grid = join(revolve(lambda q: q + np.array([1.0, 0.0]), (even(2), even(1)), Turn(2), solid=False))
    assert volume(grid) == pytest.approx(3 * np.pi / 4, rel=1e-4)
    assert np.count_nonzero(grid.near(0, 0.0)) == np.count_nonzero(grid.near(1, 0.0)) == 5 * 3


def test_graded_cells_begin_with_the_size_wanted() -> None:
    cuts = graded(0.01, 4, 12)
    assert np.diff(cuts)[:4] == pytest.approx(0.01)
    assert cuts[-1] == 1.0
    assert (np.diff(np.diff(cuts)) > -1e-12).all()


def test_outer_faces_are_those_of_the_third_axis() -> None:
    grid = join(map_block((even(2), even(2), even(2)), lambda q: q))
    cells = grid.outer_cells(grid.near(2, 1.0))
    assert len(cells) == 4
    assert (grid.nodes[grid.outer_faces(cells)][..., 2] == 1.0).all()
