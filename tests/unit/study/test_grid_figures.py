"""Figures of a grid contain the numbers of their panels, and grow by the same width with each."""

import numpy as np
import pytest

from palpate.study import cut_marker_panels, cut_tilt_panels, draw_grid, evaluate_grid
from palpate.study.draw_grid import draw_curves
from palpate.study.plot_grid import PLOT_KINDS
from results import PAPER

GRID = evaluate_grid(PAPER)


@pytest.mark.parametrize("cut", [cut_marker_panels, cut_tilt_panels])
def test_curves_are_those_of_the_panels(cut) -> None:
    panels = cut(GRID, "rmse_deg")
    widths = []
    for count in range(1, len(panels) + 1):
        figure = draw_curves(panels[:count], "title", "across", "label")
        widths.append(figure.get_size_inches()[0])
        for axis, panel in zip(figure.axes, panels[:count], strict=True):
            for line, values in zip(axis.lines, panel.values, strict=True):
                np.testing.assert_array_equal(line.get_xdata(), panel.places)
                np.testing.assert_array_equal(line.get_ydata(), values)
    assert widths == pytest.approx([1.8 + 2.6 * count for count in range(1, len(panels) + 1)])


@pytest.mark.parametrize("kind", PLOT_KINDS)
def test_each_kind_of_figure_has_a_panel_with_limits(kind: str) -> None:
    figure = draw_grid(GRID, kind=kind)
    assert all(np.ptp(axis.get_xlim()) > 0.0 for axis in figure.axes)
