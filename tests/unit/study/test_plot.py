import numpy as np
import pytest

from errors import refused
from palpate.study import cut_marker_panels, cut_tilt_panels, draw_grid, evaluate_grid, plot_grid
from results import PAPER, make_design

GRID = evaluate_grid(PAPER)


@pytest.mark.parametrize(
    ("kind", "metric", "name"),
    [
        ("heat", "rmse_over_bound", "heat_map_rmse_over_bound"),
        ("heat", "rmse_deg", "heat_map_rmse"),
        ("travel", "travel_mm", "marker_travel"),
        ("travel", "rmse_deg", "rmse_by_thickness"),
        ("depth", "bound_deg", "bound_by_depth"),
        ("tilt", "rmse_jitter_deg", "rmse_jitter_by_tilt"),
        ("markers", "max_error_deg", "max_error_by_markers"),
    ],
)
def test_every_kind_gives_png_and_svg(tmp_path, kind, metric, name):
    paths = plot_grid(GRID, kind, metric, tmp_path / "new")
    assert [path.name for path in paths] == [f"{name}.png", f"{name}.svg"]
    assert {path.name for path in (tmp_path / "new").iterdir()} == {path.name for path in paths}


@pytest.mark.parametrize(
    ("kind", "metric", "says"),
    [
        ("pie", "rmse_deg", ("picture-kind-unknown", "pie")),
        ("heat", "rsme_deg", ("column-unknown", "rsme_deg", "rmse_deg")),
        ("heat", "shape", ("metric-is-text", "shape")),
        ("depth", "travel_mm", ("metric-unknown", "travel_mm", "depth", "rmse_deg", "max_error_deg")),
        ("tilt", "bound_deg", ("metric-unknown", "bound_deg", "tilt", "rmse_deg")),
    ],
)
def test_what_cannot_be_drawn_is_reported_and_nothing_is_written(tmp_path, kind, metric, says):
    with refused(*says):
        plot_grid(GRID, kind, metric, tmp_path / "new")
    assert not (tmp_path / "new").exists()


def test_a_grid_is_drawn_without_being_written():
    assert draw_grid(GRID).axes
    with refused("column-unknown", "rms"):
        draw_grid(GRID, "rms")
    with refused("picture-kind-unknown", "pie"):
        draw_grid(GRID, kind="pie")


def test_a_metric_that_no_design_has_is_refused(tmp_path):
    with refused("metric-empty"):
        plot_grid(evaluate_grid([make_design(failure="stopped")]), "heat", "rmse_deg", tmp_path)
    with refused("grid-empty"):
        plot_grid(evaluate_grid([]), "heat", "rmse_deg", tmp_path)


def test_curves_against_markers_have_a_panel_a_height_and_a_line_a_dome():
    panels = cut_marker_panels(evaluate_grid(PAPER[::-1]), "rmse_deg")
    assert [panel.title for panel in panels] == ["H = 10 mm", "H = 20 mm", "H = 30 mm"]
    assert panels[1].places == (7.0, 37.0, 91.0, 169.0)
    curve = panels[1].values[panels[1].domes_mm.index((20.0, 3.0))]
    assert curve.tolist() == [make_design(20.0, 3.0, m).clean.pooled.rmse for m in (7, 37, 91, 169)]


def test_curves_against_tilt_stand_at_the_middle_of_each_interval():
    (panel,) = cut_tilt_panels(evaluate_grid([make_design()]), "rmse_deg")
    assert panel.places == (5.0,)
    assert panel.values.tolist() == [[make_design().clean.by_tilt[0].pooled.rmse]]
    assert np.isnan(
        cut_tilt_panels(evaluate_grid([make_design(), make_design(markers=7, failure="x")]))[0].values
    ).all()
