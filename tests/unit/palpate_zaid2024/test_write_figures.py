"""Page of the paper's tables and figures in this version."""

import re
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from palpate_zaid2024 import assess_claims, read_evidence, write_figures

from palpate.core.run import Progress
from palpate.fea import solve_press
from palpate.mechanics import SolverSpec

PUBLISHED = Path(__file__).parents[3] / "docs" / "results"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("figures")
    grids, meshes = read_evidence([PUBLISHED / "best_no_slip", PUBLISHED / "fea"])
    with pytest.MonkeyPatch.context() as changes:
        long_increments = partial(solve_press, solver=SolverSpec(edge_share=1.0))
        changes.setattr(sys.modules[write_figures.__module__], "solve_press", long_increments)
        return write_figures(folder, assess_claims(grids, meshes), grids, meshes[:1], Progress(), cells=4)


def test_every_figure_is_drawn_and_shown(page):
    shown = set(re.findall(r"\]\((\S+\.svg)\)", page.read_text("utf-8")))
    assert shown == {one.name for one in page.parent.glob("*.svg")}
    assert {name[:6] for name in shown} == {"fig_08", "fig_09", "fig_10", "fig_11", "fig_12"}


def test_printed_and_own_values_stand_side_by_side(page):
    text = page.read_text("utf-8")
    assert "| pitch | 0.570 | 0.470 | 1.640 | 0.490 |" in text
    assert "| C20 | 110.6 | 110.6 |" in text
    stresses = [float(cell) for cell in re.findall(r"H[123]0 T2 \|.*\| ([0-9.]+) \|", text)]
    assert list(np.argsort(stresses)) == [2, 1, 0]  # the order of the paper's text: H10 > H20 > H30


def test_the_state_of_the_real_sensor_comes_first(page):
    first, second = re.findall(r"^## (.*)", page.read_text("utf-8"), re.M)[:2]
    assert first.startswith("Table 3")
    assert second.startswith("Table 2")
    assert "No sensor of this design" in page.read_text("utf-8").split("## Table 2")[0]
    assert "give the folder of `palpate calibration predict` too" in page.read_text("utf-8")
