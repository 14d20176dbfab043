"""Presses and grids in a notebook: tables and pictures, and a message where nothing can be drawn."""

import ctypes
import importlib.util

import numpy as np
import pytest

from errors import refused
from palpate.core import PalpateError
from palpate.design import DomeSpec, build_skin
from palpate.fea import Press, WallSpec, plot_press, render_press_3d, tabulate_press
from palpate.fea.plot_press import check_graphics
from palpate.material import get_material
from palpate.mesh import MeshSpec, mesh_skin
from presses import solve_press


@pytest.fixture(scope="module")
def press() -> Press:
    mesh = mesh_skin(build_skin(DomeSpec(height=20, thickness=2)), MeshSpec(cells=6))
    return solve_press(mesh, get_material("zaid_2024_ecoflex_00_30"), WallSpec(tilt_deg=4, depth=1.6))


def test_a_press_draws_its_section_and_force(press):
    section, force = plot_press(press).axes
    assert len(section.lines) == 2 * 3  # two surfaces, in each of three images
    (wall,) = section.collections
    heights = wall.get_paths()[0].vertices[:, 1]
    assert np.ptp(heights) > 1.0, "it is tilted"
    assert 20.0 < heights.mean() < 22.0, "it has reached the dome"
    assert force.lines[0].get_ydata()[-1] == pytest.approx(np.linalg.norm(press.force[-1]))


def test_a_press_is_a_table_in_a_notebook(press):
    table = tabulate_press(press)
    assert table.count("<tr>") == 1 + len(press.depth)
    assert "depth reached" in table


def test_a_machine_without_graphics_is_reported(press, monkeypatch):
    def no_library(name):
        raise OSError(name)

    monkeypatch.setattr(ctypes, "CDLL", no_library)
    with refused("graphics-missing", "libEGL"):
        render_press_3d(press)


def test_a_picture_shows_the_dome(press):
    try:
        check_graphics()
    except PalpateError:
        pytest.skip("no OpenGL here")
    if importlib.util.find_spec("pyvista") is None:
        with refused("extra-missing"):
            render_press_3d(press)
        return
    picture = render_press_3d(press)
    assert picture.shape == (600, 800, 3)
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 50
